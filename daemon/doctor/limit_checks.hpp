// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>

#include "config/rig_config.hpp"
#include "daemon/doctor/check.hpp"

namespace eha::doctor {

/// Judges the limits of a rig file. Fails if the rig cannot be armed (arming_findings). Warns of a missing [following]
/// and of what limit_remarks() says.
[[nodiscard]] Check check_limits(const config::RigConfig& rig, std::chrono::sys_days today);

/// The same of today.
[[nodiscard]] Check check_limits(const config::RigConfig& rig);

}  // namespace eha::doctor
