// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

#include "config/rig_config.hpp"

namespace eha::config {

/// Fastest speed of a placing: 0.3 in/s, at most a tenth of the rig's velocity limit [in/s].
[[nodiscard]] inline double placing_speed_in_per_s(const RigLimits& limits) noexcept {
  constexpr double kUsual_in_per_s = 0.3;
  constexpr double kShareOfVelocityLimit = 0.1;
  return std::min(kUsual_in_per_s, kShareOfVelocityLimit * limits.velocity_limit_in_per_s);
}

}  // namespace eha::config
