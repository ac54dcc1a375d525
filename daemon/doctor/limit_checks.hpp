// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/rig_config.hpp"
#include "daemon/doctor/check.hpp"

namespace eha::doctor {

/// Judges the limits of a rig file. Fails if the rig cannot be armed (arming_findings). Warns of a missing [following],
/// a disabled check for a frozen sensor, and a loop that may be late for longer than a person needs to react. These
/// limits are this project's own, not from a standard.
[[nodiscard]] Check check_limits(const config::RigConfig& rig);

}  // namespace eha::doctor
