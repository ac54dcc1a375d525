// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/rig_config.hpp"
#include "daemon/doctor/check.hpp"

namespace eha::doctor {

/// Warns about limits of a real rig that are valid but too loose to protect it: no check for a frozen sensor, a speed
/// or a deceleration that no cylinder reaches, a loop that may be late for longer than a person needs to react. The
/// thresholds are this project's own, not a standard's.
[[nodiscard]] Check check_limits(const config::RigLimits& limits, const config::RealtimeOptions& realtime);

}  // namespace eha::doctor
