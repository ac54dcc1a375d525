// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/limit_monitor.hpp"

#include <algorithm>
#include <cmath>

namespace eha::acquisition {
namespace {

constexpr double kJumpTolerance_s = 0.010;
constexpr double kJumpOfNoise_in = 0.01;  // below 0.9 in/s noise would count as a jump: 0.0022 in at 0.2 in/s
constexpr double kOutward_in = 0.1;       // on the way back: more than the noise that arming allows
constexpr double kDrivenShare = 0.10;     // wider than the dead band of the intended valves, some 1 to 5 %

}  // namespace

LimitMonitor::LimitMonitor(const config::RigLimits& limits, double period_s) noexcept
    : limits_(limits),
      period_s_(period_s),
      driven_V_(kDrivenShare * 0.5 * (limits.command_max_V - limits.command_min_V)),
      window_(config::velocity_window(period_s)) {}

Breach LimitMonitor::check(std::int64_t at_ns, const hal::RigReading& reading, double applied_V) noexcept {
  if (reading.emergency_stop) return {Fault::emergency_stop};
  if (reading.feedback_at_rail) return {Fault::feedback_rail, reading.feedback_V};
  if (!std::isfinite(reading.displacement_in)) return {Fault::feedback_not_finite, reading.displacement_in};
  if (limits_.sensor && reading.feedback_V < limits_.sensor->valid_min_V) {
    return {Fault::feedback_band, reading.feedback_V, limits_.sensor->valid_min_V};
  }
  if (limits_.sensor && reading.feedback_V > limits_.sensor->valid_max_V) {
    return {Fault::feedback_band, reading.feedback_V, limits_.sensor->valid_max_V};
  }
  const Breach jump = check_jump(at_ns, reading.displacement_in);
  estimate_velocity(at_ns, reading.displacement_in);
  has_jumped_ = jump.fault != Fault::none;
  if (has_jumped_) return jump;
  if (const Breach breach = check_travel(reading.displacement_in); breach.fault != Fault::none) return breach;
  if (std::abs(velocity_in_per_s_) > limits_.velocity_limit_in_per_s) {
    return {Fault::velocity_limit, velocity_in_per_s_,
            std::copysign(limits_.velocity_limit_in_per_s, velocity_in_per_s_)};
  }
  if (is_frozen(at_ns, reading.feedback_code, applied_V)) {
    return {Fault::frozen_sensor, unchanged_s_, limits_.frozen_sensor_s};
  }
  return {};
}

Breach LimitMonitor::check_jump(std::int64_t at_ns, double displacement_in) const noexcept {
  if (readings_ == 0) return {};
  const std::size_t last = (readings_ - 1) % window_;
  const double since_last_s = static_cast<double>(at_ns - times_ns_[last]) * kSecondsPerNanosecond;
  const double jump_in = displacement_in - positions_in_[last];
  const double most_in = limits_.velocity_limit_in_per_s * (since_last_s + kJumpTolerance_s);
  if (std::abs(jump_in) <= std::max(most_in, kJumpOfNoise_in)) return {};
  return {Fault::velocity_limit, jump_in / since_last_s, std::copysign(limits_.velocity_limit_in_per_s, jump_in)};
}

void LimitMonitor::estimate_velocity(std::int64_t at_ns, double displacement_in) noexcept {
  times_ns_[readings_ % window_] = at_ns;
  positions_in_[readings_ % window_] = displacement_in;
  ++readings_;
  if (readings_ < window_) return;
  double mean_time_s = 0.0;
  double mean_in = 0.0;
  for (std::size_t i = 0; i < window_; ++i) {
    mean_time_s += static_cast<double>(times_ns_[i] - at_ns) * kSecondsPerNanosecond;
    mean_in += positions_in_[i];
  }
  mean_time_s /= static_cast<double>(window_);
  mean_in /= static_cast<double>(window_);
  double numerator = 0.0;
  double denominator = 0.0;
  for (std::size_t i = 0; i < window_; ++i) {
    const double time_s = static_cast<double>(times_ns_[i] - at_ns) * kSecondsPerNanosecond - mean_time_s;
    numerator += time_s * (positions_in_[i] - mean_in);
    denominator += time_s * time_s;
  }
  velocity_in_per_s_ = numerator / denominator;
}

Breach LimitMonitor::check_travel(double displacement_in) noexcept {
  // Not for a rod at rest, which could otherwise not be driven away from a near end.
  const auto stopping_in = [&](double velocity_towards_end) {
    return velocity_towards_end > 0.0 ? config::stopping_distance_in(limits_, period_s_, velocity_towards_end) : 0.0;
  };
  const double lowest_in = displacement_in - stopping_in(-velocity_in_per_s_);
  const double highest_in = displacement_in + stopping_in(velocity_in_per_s_);
  const double middle_in = limits_.mid_travel_in();
  const double half_in = 0.5 * (limits_.travel_max_in - limits_.travel_min_in);
  travel_share_ = std::max(middle_in - lowest_in, highest_in - middle_in) / half_in;
  double lower_limit_in = limits_.travel_min_in;
  double upper_limit_in = limits_.travel_max_in;
  if (way_back_) {
    const bool is_first = readings_ == 1;
    lower_reached_in_ = is_first ? displacement_in : std::max(lower_reached_in_, displacement_in);
    upper_reached_in_ = is_first ? displacement_in : std::min(upper_reached_in_, displacement_in);
    lower_limit_in = std::min(lower_limit_in, lower_reached_in_ - kOutward_in);
    upper_limit_in = std::max(upper_limit_in, upper_reached_in_ + kOutward_in);
  }
  if (lowest_in < lower_limit_in) return {Fault::travel_limit, lowest_in, lower_limit_in};
  if (highest_in > upper_limit_in) return {Fault::travel_limit, highest_in, upper_limit_in};
  return {};
}

bool LimitMonitor::is_frozen(std::int64_t at_ns, std::uint32_t code, double applied_V) noexcept {
  const bool is_first = readings_ == 1;
  const double since_last_s = static_cast<double>(at_ns - last_at_ns_) * kSecondsPerNanosecond;
  const bool is_driven = std::abs(applied_V - limits_.safe_V) > driven_V_;
  if (is_first || code != last_code_) {
    unchanged_s_ = 0.0;
  } else if (is_driven) {
    unchanged_s_ += since_last_s;
  }
  last_code_ = code;
  last_at_ns_ = at_ns;
  // Half a period of slack avoids a comparison near the rounding of the sum.
  return limits_.frozen_sensor_s > 0.0 && unchanged_s_ + 0.5 * period_s_ >= limits_.frozen_sensor_s;
}

}  // namespace eha::acquisition
