// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/rig_config.hpp"
#include "daemon/doctor/check.hpp"

namespace eha::doctor {

/// Warns about limits of a real rig that a rig file may hold but that protect from nothing: the frozen sensor not
/// looked for, a speed or a deceleration no cylinder reaches, a loop that may be late for longer than a person needs to
/// react. A judgement of this project's own, no standard's.
[[nodiscard]] Check check_limits(const config::RigLimits& limits, const config::RealtimeOptions& realtime);

}  // namespace eha::doctor
