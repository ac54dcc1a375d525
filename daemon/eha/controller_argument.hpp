// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/tune/controller_page.hpp"

namespace eha::cli {

/// Whether a command line names a controller file. @throws ConfigError  a TOML file that cannot be read
[[nodiscard]] bool is_controller_file(const std::string& path);

/// Returns the controller with its model, rig and a trial on its twin, if these files are unchanged.
/// @throws ConfigError, IoError, PermissionError
[[nodiscard]] tune::ControllerSubject controller_subject(config::ControllerConfig controller);

/// Returns the unit of lengths of the controller's rig file; empty if the file can no longer be read.
[[nodiscard]] std::string rig_units_of_controller(const config::ControllerConfig& controller);

/// `eha track CONTROLLER`, on a simulated rig with --local --fast and its rig file as `eha tune` offers it.
[[nodiscard]] std::string track_of_controller(const std::string& file, const config::ControllerConfig& controller);

}  // namespace eha::cli
