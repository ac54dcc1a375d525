// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/rig_config.hpp"
#include "daemon/doctor/check.hpp"

namespace eha::doctor {

/// Judges the limits of a rig file: fails where the rig cannot be armed (arming_findings), and warns of what it is
/// armed with all the same: no [following], a frozen sensor not looked for, a loop that may be late for longer than a
/// person needs to react. A judgement of this project's own, no standard's.
[[nodiscard]] Check check_limits(const config::RigConfig& rig);

}  // namespace eha::doctor
