// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/place/place_controller.hpp"

#include <algorithm>
#include <cmath>

#include "config/valve_estimate.hpp"

namespace eha::place {
namespace {

constexpr double kSpeed_in_per_s = 0.3;
constexpr double kShareOfVelocityLimit = 0.1;
constexpr double kApproach_per_s = 1.5;
constexpr double kBias_rad_s = 3.0;
constexpr double kVelocityFilter_s = 0.1;
constexpr double kRest_in = 0.005;
constexpr double kRest_in_per_s = 0.025;         ///< ten times what leakage moves the rod by
constexpr double kFullDeadBand_in_per_s = 0.02;  ///< speed from which the whole dead band is added
constexpr double kSpare_V = 0.3;
constexpr double kShareOfRangeWithoutGains = 0.4;
/// Below this share of its way the rod counts as not moving.
constexpr double kLeastShareOfWay = 0.2;
constexpr double kTimeToFindTheNull_s = 20.0;

}  // namespace

double placing_speed_in_per_s(const config::RigLimits& limits) noexcept {
  return std::min(kSpeed_in_per_s, kShareOfVelocityLimit * limits.velocity_limit_in_per_s);
}

double placing_time_s(const config::RigLimits& limits, double way_in) noexcept {
  const double delay_s = limits.following ? limits.following->pressure_delay_s : 0.0;
  return kTimeToFindTheNull_s + delay_s + 2.0 * std::abs(way_in) / placing_speed_in_per_s(limits);
}

PlaceController::PlaceController(const config::RigLimits& limits, double period_s, double target_in) noexcept
    : period_s_(period_s), target_in_(target_in), speed_in_per_s_(placing_speed_in_per_s(limits)) {
  const double half_range_V = 0.5 * (limits.command_max_V - limits.command_min_V);
  if (limits.following) {
    const config::ValveEstimate valve = config::valve_estimate(*limits.following);
    gain_positive_in_per_V_s_ = valve.gain_positive_in_per_V_s;
    gain_negative_in_per_V_s_ = valve.gain_negative_in_per_V_s;
    null_V_ = valve.null_V;
    dead_band_V_ = valve.dead_band_V;
    const double slower = std::min(gain_positive_in_per_V_s_, gain_negative_in_per_V_s_);
    most_V_ = dead_band_V_ + speed_in_per_s_ / slower + kSpare_V;
  } else {
    gain_positive_in_per_V_s_ = limits.velocity_limit_in_per_s / half_range_V / 3.0;
    gain_negative_in_per_V_s_ = gain_positive_in_per_V_s_;
    null_V_ = limits.safe_V;
    dead_band_V_ = 0.0;
    most_V_ = kShareOfRangeWithoutGains * half_range_V;
  }
  bias_V_ = null_V_;
}

double PlaceController::voltage_V(const hal::RigReading& last) noexcept {
  const double position_in = last.displacement_in;
  if (!has_begun_) {
    has_begun_ = true;
    start_in_ = position_in;
    filtered_in_ = position_in;
  }
  last_in_ = position_in;
  const double velocity_in_per_s = (position_in - filtered_in_) / kVelocityFilter_s;
  filtered_in_ += period_s_ / kVelocityFilter_s * (position_in - filtered_in_);
  steady_in_per_s_ += period_s_ / kVelocityFilter_s * (velocity_in_per_s - steady_in_per_s_);

  const double error_in = target_in_ - position_in;
  const bool rests = std::abs(error_in) < kTolerance_in && std::abs(steady_in_per_s_) < kRest_in_per_s;
  settled_s_ = rests ? settled_s_ + period_s_ : 0.0;
  const double wanted_in_per_s =
      std::abs(error_in) < kRest_in ? 0.0 : std::clamp(kApproach_per_s * error_in, -speed_in_per_s_, speed_in_per_s_);
  const double gain = wanted_in_per_s >= 0.0 ? gain_positive_in_per_V_s_ : gain_negative_in_per_V_s_;
  const double ahead_V =
      wanted_in_per_s / gain + dead_band_V_ * std::clamp(wanted_in_per_s / kFullDeadBand_in_per_s, -1.0, 1.0);
  const double step_V = kBias_rad_s / gain * (wanted_in_per_s - velocity_in_per_s) * period_s_;
  bias_V_ = std::clamp(bias_V_ + step_V, null_V_ - most_V_, null_V_ + most_V_);
  return std::clamp(bias_V_ + ahead_V, null_V_ - most_V_, null_V_ + most_V_);
}

double PlaceController::way_in() const noexcept { return std::abs(target_in_ - start_in_); }

acquisition::Breach PlaceController::failure() const noexcept {
  const double moved_in = (last_in_ - start_in_) * (target_in_ >= start_in_ ? 1.0 : -1.0);
  if (moved_in < kLeastShareOfWay * way_in() && way_in() > kTolerance_in) {
    return {acquisition::Fault::no_motion, moved_in, way_in()};
  }
  return {acquisition::Fault::not_in_place, std::abs(target_in_ - last_in_), kTolerance_in};
}

}  // namespace eha::place
