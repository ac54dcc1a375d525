// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/place/loop_monitor.hpp"

#include <algorithm>
#include <cmath>

namespace eha::place {
namespace {

using acquisition::Fault;

// Pinned by slip_campaign_test.cpp: simulated rigs, sound and not, with one number of [following] wrong.
constexpr double kSpareVolts_V = 0.3;         ///< beyond what the speed needs
constexpr double kFirstSpeed_in_per_s = 0.1;  ///< at once, so that a dead sensor shows soon
constexpr double kMostFirst_V = 0.1;
constexpr double kAcceleration_in_per_s2 = 1.3;
constexpr double kLeastGrowthShare = 0.1;  ///< of half the command range, each second
constexpr double kMostGrowthShare = 0.6;
/// What a velocity limit of 8 in/s at 5 V allows. A low limit, or a wide range, does not show that the rod is slow.
constexpr double kMostGrowth_V_per_s = 0.8;
constexpr double kGrowthSlack_V = 0.1;  ///< that the growth does not lose when the command goes back: noise
constexpr double kSpeedFactor = 2.5;
constexpr double kSpeedWindow_s = 0.05;
constexpr double kSpeedErrors = 4.0;
constexpr double kFilter_s = 0.05;
constexpr double kNoise_s = 0.5;  ///< time constant of the noise's estimate
constexpr double kNoiseDeviations = 6.0;
/// Some more than the noise of a sensor that arming takes makes of it, at any tick. More noise, or hum, is of an open
/// wire, and must not hide that nothing follows.
constexpr double kMostStill_in = 0.012;
constexpr double kStill_in = 0.003;
constexpr double kStillSpare_V = 0.1;           ///< beyond the dead band of [following]
constexpr double kStillShare = 0.2;             ///< of half the command range: without [following]
constexpr double kLeastGainShare = 1.0 / 20.0;  ///< of the gain that fills the velocity limit at half the command range
constexpr double kLeastShareOfHalfGain = 0.5;  ///< of the gain of [following]: on a fast rod a dead sensor shows sooner
constexpr double kSaturated_s = 0.3;
constexpr double kSaturatedShare = 0.99;
constexpr double kSlowShare = 0.7;
constexpr double kFastShare = 1.6;
constexpr double kValveError_V = 0.03;
constexpr double kSlowFloor_in_per_s = 0.01;
constexpr double kFastFloor_in_per_s = 0.03;
constexpr double kWrongSpeed_s = 0.5;
constexpr double kNullError_in_per_s = 0.02;  ///< what the valve's error may do to a mean speed, however fast the rod
constexpr double kLackingShare = 0.85;        ///< of the way that the volts ask for
constexpr double kMostLacking_in = 0.04;      ///< of that share

}  // namespace

LoopBounds loop_bounds(const config::RigLimits& limits, double speed_in_per_s) noexcept {
  const double half_range_V = 0.5 * (limits.command_max_V - limits.command_min_V);
  const double full_gain = limits.velocity_limit_in_per_s / half_range_V;
  LoopBounds bounds{.null_V = limits.safe_V,
                    .edge_V = 0.0,
                    .most_V = config::closed_loop_most_V(limits),
                    .growth_V_per_s = std::min(kMostGrowth_V_per_s, std::clamp(kAcceleration_in_per_s2 / full_gain,
                                                                               kLeastGrowthShare * half_range_V,
                                                                               kMostGrowthShare * half_range_V)),
                    .speed_limit_in_per_s = kSpeedFactor * speed_in_per_s,
                    .still_V = kStillShare * half_range_V,
                    .least_gain_in_per_V_s = kLeastGainShare * full_gain};
  if (!limits.following) return bounds;
  const config::Following& following = *limits.following;
  const config::ValveEstimate valve = config::valve_estimate(following);
  const double slower = std::min(valve.gain_positive_in_per_V_s, valve.gain_negative_in_per_V_s);
  bounds.null_V = valve.null_V;
  const double faster = std::max(valve.gain_positive_in_per_V_s, valve.gain_negative_in_per_V_s);
  bounds.edge_V = valve.dead_band_V + std::min(kMostFirst_V, kFirstSpeed_in_per_s / faster);
  bounds.most_V = std::min(bounds.most_V, valve.dead_band_V + speed_in_per_s / slower + kSpareVolts_V);
  bounds.still_V = following.dead_band_V + kStillSpare_V;
  const double least = std::min(following.gain_positive_in_per_V_s, following.gain_negative_in_per_V_s);
  bounds.least_gain_in_per_V_s = std::max(std::min(bounds.least_gain_in_per_V_s, least), kLeastShareOfHalfGain * least);
  bounds.pressure_delay_s = following.pressure_delay_s;
  bounds.valve = valve;
  return bounds;
}

LoopMonitor::LoopMonitor(const LoopBounds& bounds, double period_s) noexcept
    : bounds_(bounds),
      period_s_(period_s),
      weight_(period_s / (kFilter_s + period_s)),
      window_(static_cast<std::size_t>(
          std::clamp(std::round(kSpeedWindow_s / period_s) + 1.0, 3.0, static_cast<double>(kLongestWindow)))),
      authority_V_{bounds.edge_V, bounds.edge_V},
      command_V_(bounds.null_V),
      filtered_V_(bounds.null_V),
      twice_V_(bounds.null_V),
      slope_(period_s) {}

double LoopMonitor::bounded_V(double wanted_V, const hal::RigReading& last) noexcept {
  take(last, false);
  const double wished_V = wanted_V - bounds_.null_V;
  const bool has_pressure = elapsed_s_ >= bounds_.pressure_delay_s;
  for (std::size_t i = 0; i < authority_V_.size(); ++i) {
    const double used_V = (i == 0 ? wished_V : -wished_V) + kGrowthSlack_V;
    const double grown_V = authority_V_[i] + (has_pressure ? bounds_.growth_V_per_s * period_s_ : 0.0);
    authority_V_[i] = std::max(bounds_.edge_V, std::min(grown_V, used_V));
  }
  const double most_V = has_pressure ? bounds_.most_V : 0.0;
  command_V_ =
      bounds_.null_V + std::clamp(wished_V, -std::min(authority_V_[1], most_V), std::min(authority_V_[0], most_V));
  const bool is_saturated = std::abs(command_V_ - bounds_.null_V) >= kSaturatedShare * bounds_.most_V;
  saturated_s_ = is_saturated ? saturated_s_ + period_s_ : 0.0;
  return command_V_;
}

void LoopMonitor::note(double command_V, bool is_saturated, const hal::RigReading& last) noexcept {
  take(last, !is_saturated);
  command_V_ = command_V;
}

void LoopMonitor::take(const hal::RigReading& last, bool may_be_still) noexcept {
  const double place_in = last.displacement_in;
  if (readings_ == 0) {
    filtered_in_ = place_in;
    last_in_ = place_in;
  }
  elapsed_s_ += period_s_;
  estimate_noise(place_in);
  check_speed(place_in);
  const double moved_in = weight_ * (place_in - filtered_in_);
  filtered_in_ += moved_in;
  filtered_V_ += weight_ * (command_V_ - filtered_V_);
  twice_V_ += weight_ * (filtered_V_ - twice_V_);
  speed_in_per_s_ += weight_ * (moved_in / period_s_ - speed_in_per_s_);
  if (elapsed_s_ <= bounds_.pressure_delay_s) return;
  if (may_be_still) {
    missing_in_ = due_in_ = due_s_ = {};
    return;
  }
  check_motion(moved_in);
  if (std::isinf(bounds_.speed_limit_in_per_s)) return;
  check_saturation();
  compare_speed();
}

void LoopMonitor::estimate_noise(double place_in) noexcept {
  // The second difference has six times the noise's variance and nothing of a steady motion, which at a long tick
  // would pass for noise.
  const double change_in = place_in - last_in_;
  const double bend_in = change_in - last_change_in_;
  last_in_ = place_in;
  last_change_in_ = change_in;
  const double weight = std::max(period_s_ / kNoise_s, 1.0 / static_cast<double>(readings_ + 1));
  variance_in2_ += weight * (bend_in * bend_in / 6.0 - variance_in2_);
}

void LoopMonitor::check_speed(double place_in) noexcept {
  places_in_[readings_ % window_] = place_in;
  ++readings_;
  if (readings_ < window_) return;
  // x runs from -m to m, one a reading, the newest last.
  const auto n = static_cast<double>(window_);
  const double m = 0.5 * (n - 1.0);
  double mean_in = 0.0;
  for (std::size_t i = 0; i < window_; ++i) mean_in += places_in_[i] / n;
  double along = 0.0;
  double squares_in2 = 0.0;
  for (std::size_t i = 0; i < window_; ++i) {
    const double off_in = places_in_[(readings_ + i) % window_] - mean_in;
    along += (static_cast<double>(i) - m) * off_in;
    squares_in2 += off_in * off_in;
  }
  const double spread = n * (n * n - 1.0) / 12.0;
  const double slope = along / spread;
  const double residual_in2 = std::max(0.0, squares_in2 - slope * along) / (n - 2.0);
  const double speed = std::abs(slope) / period_s_;
  const double error = std::sqrt(residual_in2 / spread) / period_s_;
  if (speed - kSpeedErrors * error > bounds_.speed_limit_in_per_s) {
    trip({Fault::loop_speed, speed, bounds_.speed_limit_in_per_s});
  }
}

double LoopMonitor::least_motion_in() const noexcept {
  // A low-pass filter of time constant tau leaves T / (2 tau) of a white noise's variance.
  const double noise_in = kNoiseDeviations * std::sqrt(variance_in2_ * period_s_ / (2.0 * kFilter_s));
  return std::clamp(noise_in, kStill_in, kMostStill_in);
}

void LoopMonitor::check_motion(double moved_in) noexcept {
  const double direction = std::copysign(1.0, filtered_V_ - bounds_.null_V);
  const std::size_t i = direction > 0.0 ? 0 : 1;
  const double outside_V = direction * (filtered_V_ - bounds_.null_V) - bounds_.still_V;
  if (outside_V <= 0.0) return;
  const double due_in = bounds_.least_gain_in_per_V_s * outside_V * period_s_;
  missing_in_[i] = std::max(0.0, missing_in_[i] + due_in - direction * moved_in);
  due_in_[i] = missing_in_[i] > 0.0 ? due_in_[i] + due_in : 0.0;
  due_s_[i] = missing_in_[i] > 0.0 ? due_s_[i] + period_s_ : 0.0;
  if (missing_in_[i] > least_motion_in()) {
    trip({Fault::no_motion, due_in_[i] - missing_in_[i], due_in_[i], command_V_, due_s_[i]});
  }
}

void LoopMonitor::check_saturation() noexcept {
  if (saturated_s_ <= period_s_) saturated_from_in_ = filtered_in_;
  if (saturated_s_ < kSaturated_s) return;
  const double moved_in = std::copysign(1.0, command_V_ - bounds_.null_V) * (filtered_in_ - saturated_from_in_);
  if (moved_in < least_motion_in()) {
    trip({Fault::no_motion, moved_in, least_motion_in(), command_V_, saturated_s_});
  }
  saturated_s_ = 0.0;
}

void LoopMonitor::compare_speed() noexcept {
  if (!bounds_.valve) return;
  const double direction = std::copysign(1.0, twice_V_ - bounds_.null_V);
  const double gain =
      direction > 0.0 ? bounds_.valve->gain_positive_in_per_V_s : bounds_.valve->gain_negative_in_per_V_s;
  const double outside_V = direction * (twice_V_ - bounds_.null_V) - bounds_.valve->dead_band_V;
  const double speed = direction * speed_in_per_s_;
  const double least = kSlowShare * gain * (outside_V - kValveError_V) - kSlowFloor_in_per_s;
  const double most = kFastShare * gain * std::max(0.0, outside_V + kValveError_V) + kFastFloor_in_per_s;
  slow_s_ = least > 0.0 && speed < least ? slow_s_ + period_s_ : 0.0;
  fast_s_ = speed > most ? fast_s_ + period_s_ : 0.0;
  if (slow_s_ > kWrongSpeed_s) trip({Fault::wrong_speed, speed, least});
  if (fast_s_ > kWrongSpeed_s) trip({Fault::wrong_speed, speed, most});
  if (!bounds_.compares_slope)
    add_lacking(kLackingShare * gain * outside_V - std::min(kLackingShare * gain * kValveError_V, kNullError_in_per_s),
                speed);
  if (!bounds_.compares_slope) return;
  const double open_V = direction * (filtered_V_ - bounds_.null_V) - bounds_.valve->dead_band_V;
  slope_.note(direction, open_V, gain * outside_V, speed);
  if (slope_.is_low()) trip({Fault::wrong_speed, slope_.mean_in_per_s(), slope_.least_mean_in_per_s()});
}

void LoopMonitor::add_lacking(double due_in_per_s, double speed_in_per_s) noexcept {
  const double least_in_per_s = due_in_per_s - kSlowFloor_in_per_s;
  if (least_in_per_s <= 0.0) return;
  lacking_.way_in += (least_in_per_s - speed_in_per_s) * period_s_;
  lacking_.asked_in += least_in_per_s * period_s_;
  lacking_.asked_s += period_s_;
  if (lacking_.way_in <= 0.0) lacking_ = {};
  if (lacking_.way_in > kMostLacking_in) {
    trip({Fault::wrong_speed, (lacking_.asked_in - lacking_.way_in) / lacking_.asked_s,
          lacking_.asked_in / lacking_.asked_s});
  }
}

void LoopMonitor::trip(const acquisition::Breach& breach) noexcept {
  if (breach_.fault == Fault::none) breach_ = breach;
}

}  // namespace eha::place
