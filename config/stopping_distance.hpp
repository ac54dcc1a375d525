// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "config/rig_config.hpp"

namespace eha::config {

/// Greatest number of readings in the straight line whose slope is the tick's velocity. The line spans 20 ms, at least
/// 3 readings.
inline constexpr std::size_t kLongestVelocityWindow = 64;

[[nodiscard]] inline std::size_t velocity_window(double period_s) noexcept {
  constexpr double kWindow_s = 0.020;
  return static_cast<std::size_t>(
      std::clamp(std::round(kWindow_s / period_s) + 1.0, 3.0, static_cast<double>(kLongestVelocityWindow)));
}

/// Distance that a rod needs to stop; the tick keeps the rod this far from a travel limit [in]:
///   w T + w^2 / (2 a),   w = v + min(a t, velocity limit)
/// T is a tick and a the rig's stopping deceleration. t is the age of the estimate v, half its window and a tick;
/// within that time the rod may have gained speed undetected. LimitMonitor trips at this distance; rehearsal and
/// placing respect it.
/// Real-time safe.
/// @param speed_in_per_s  v, towards the limit, at least 0
[[nodiscard]] inline double stopping_distance_in(const RigLimits& limits, double period_s,
                                                 double speed_in_per_s) noexcept {
  const double braking = limits.stopping_deceleration_in_per_s2;
  const double age_s = (0.5 * static_cast<double>(velocity_window(period_s) - 1) + 1.0) * period_s;
  const double speed = speed_in_per_s + std::min(braking * age_s, limits.velocity_limit_in_per_s);
  return speed * period_s + speed * speed / (2.0 * braking);
}

}  // namespace eha::config
