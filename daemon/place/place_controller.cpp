// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/place/place_controller.hpp"

#include <algorithm>
#include <cmath>

#include "config/placing_speed.hpp"

namespace eha::place {
namespace {

constexpr double kApproach_per_s = 1.5;
constexpr double kBias_rad_s = 3.0;
constexpr double kVelocityFilter_s = 0.1;
constexpr double kRest_in = 0.005;
constexpr double kRest_in_per_s = 0.025;         ///< ten times what leakage moves the rod by
constexpr double kFullDeadBand_in_per_s = 0.02;  ///< speed from which the whole dead band is added
constexpr double kWindUp_V = 0.1;  ///< that the bounds may hold the command back by before the integral stands
/// Below this share of its way the rod counts as not moving.
constexpr double kLeastShareOfWay = 0.2;
constexpr double kTimeToFindTheNull_s = 20.0;
constexpr double kLeastShareOfSpeed = 0.2;  ///< that the time-out allows for

}  // namespace

double placing_time_s(const config::RigLimits& limits, double way_in) noexcept {
  const double wanted = config::placing_speed_in_per_s(limits);
  const LoopBounds bounds = loop_bounds(limits, wanted);
  double reached = wanted;
  if (const auto& valve = bounds.valve) {
    const double slower = std::min(valve->gain_positive_in_per_V_s, valve->gain_negative_in_per_V_s);
    reached = std::clamp(slower * (bounds.most_V - bounds.edge_V), kLeastShareOfSpeed * wanted, wanted);
  }
  return kTimeToFindTheNull_s + bounds.pressure_delay_s + 2.0 * std::abs(way_in) / reached;
}

PlaceController::PlaceController(const config::RigLimits& limits, double period_s, double target_in) noexcept
    : period_s_(period_s),
      target_in_(target_in),
      speed_in_per_s_(config::placing_speed_in_per_s(limits)),
      monitor_(loop_bounds(limits, speed_in_per_s_), period_s),
      bias_V_(monitor_.bounds().null_V) {
  if (const auto& valve = monitor_.bounds().valve) {
    gain_positive_in_per_V_s_ = valve->gain_positive_in_per_V_s;
    gain_negative_in_per_V_s_ = valve->gain_negative_in_per_V_s;
    dead_band_V_ = valve->dead_band_V;
  } else {
    const double half_range_V = 0.5 * (limits.command_max_V - limits.command_min_V);
    gain_positive_in_per_V_s_ = limits.velocity_limit_in_per_s / half_range_V / 3.0;
    gain_negative_in_per_V_s_ = gain_positive_in_per_V_s_;
    dead_band_V_ = 0.0;
  }
}

double PlaceController::voltage_V(const hal::RigReading& last) noexcept {
  const double position_in = last.displacement_in;
  if (!has_begun_) {
    has_begun_ = true;
    start_in_ = position_in;
    filtered_in_ = position_in;
  }
  const double velocity_in_per_s = (position_in - filtered_in_) / kVelocityFilter_s;
  filtered_in_ += period_s_ / kVelocityFilter_s * (position_in - filtered_in_);
  steady_in_per_s_ += period_s_ / kVelocityFilter_s * (velocity_in_per_s - steady_in_per_s_);

  const double error_in = target_in_ - position_in;
  const bool rests = std::abs(error_in) < kTolerance_in && std::abs(steady_in_per_s_) < kRest_in_per_s;
  settled_s_ = rests && monitor_.has_pressure() ? settled_s_ + period_s_ : 0.0;
  const double wanted_in_per_s =
      std::abs(error_in) < kRest_in ? 0.0 : std::clamp(kApproach_per_s * error_in, -speed_in_per_s_, speed_in_per_s_);
  const double gain = wanted_in_per_s >= 0.0 ? gain_positive_in_per_V_s_ : gain_negative_in_per_V_s_;
  const double ahead_V =
      wanted_in_per_s / gain + dead_band_V_ * std::clamp(wanted_in_per_s / kFullDeadBand_in_per_s, -1.0, 1.0);
  const double step_V = kBias_rad_s / gain * (wanted_in_per_s - velocity_in_per_s) * period_s_;
  const double wanted_V = bias_V_ + step_V + ahead_V;
  const double command_V = monitor_.bounded_V(wanted_V, last);
  // Held back by less, the integral goes on: noise alone would otherwise stop its steps of one sign only.
  const double held_back_V = std::copysign(1.0, step_V) * (wanted_V - command_V);
  if (held_back_V < kWindUp_V) bias_V_ += step_V;
  return command_V;
}

double PlaceController::way_in() const noexcept { return std::abs(target_in_ - start_in_); }

acquisition::Breach PlaceController::failure() const noexcept {
  // A reading that scatters says nothing by its last value.
  const double moved_in = (filtered_in_ - start_in_) * (target_in_ >= start_in_ ? 1.0 : -1.0);
  if (moved_in < kLeastShareOfWay * way_in() && way_in() > kTolerance_in) {
    return {acquisition::Fault::no_motion, moved_in, way_in()};
  }
  return {acquisition::Fault::not_in_place, std::abs(target_in_ - filtered_in_), kTolerance_in};
}

}  // namespace eha::place
