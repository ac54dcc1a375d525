// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "config/rig_config.hpp"

namespace eha {

/// Returns the limits that one rig file sets narrower than another, of travel, command range, velocity and slew, such
/// as "command_max 3 V (5 V in force)"; lengths in the unit of the rig in force. Another calibration is one, too: with
/// it the travel limits lie elsewhere.
[[nodiscard]] std::vector<std::string> narrower_limits(const config::RigConfig& in_force,
                                                       const config::RigConfig& edited);

/// Refuses a motion on limits that the owner of the rig has narrowed since they were read, and where the file is not
/// valid, as nobody can tell which limits it means. Reads the file; one that is gone narrows nothing.
/// @throws ConfigError
void require_no_narrower_limits(const config::RigConfig& in_force, const std::filesystem::path& file,
                                std::string_view remedy = "eha disarm, eha reload, eha arm");

}  // namespace eha
