// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/tune/controller_page.hpp"

namespace eha::cli {

/// Whether a command line names a controller file. @throws ConfigError  a TOML file that cannot be read
[[nodiscard]] bool is_controller_file(const std::string& path);

/// The controller with its model, rig and a trial on its twin, where these files are still the same.
/// @throws ConfigError, IoError, PermissionError
[[nodiscard]] tune::ControllerSubject controller_subject(config::ControllerConfig controller);

/// The unit of lengths that the rig of a controller asks for; empty where its file cannot be read any more.
[[nodiscard]] std::string rig_units_of_controller(const config::ControllerConfig& controller);

}  // namespace eha::cli
