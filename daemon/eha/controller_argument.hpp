// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/tune/controller_page.hpp"

namespace eha::cli {

/// Whether a command line names a controller file. @throws ConfigError  a TOML file that cannot be read
[[nodiscard]] bool is_controller_file(const std::string& path);

/// ", written 2026-01-31 14:05 UTC" of a controller's file; empty where that is not known.
[[nodiscard]] std::string written_words(const std::filesystem::path& file);

/// Returns the controller with its model, rig and a trial on its twin, if these files are unchanged.
/// @throws ConfigError, IoError, PermissionError
[[nodiscard]] tune::ControllerSubject controller_subject(config::ControllerConfig controller);

/// Returns the unit of lengths of the controller's rig file; empty if the file can no longer be read.
[[nodiscard]] std::string rig_units_of_controller(const config::ControllerConfig& controller);

/// How a rig is reached for the trial of a controller: a machine through the service, a simulated rig of a run of the
/// service too, another one in this process.
/// @param rig_name  for --rig; empty: the default one   @param run  that the controller's model is from
[[nodiscard]] suggest::RigAccess access_of_rig(const config::RigConfig& rig, const std::string& rig_name,
                                               const std::string& run);

/// The same for the rig that a controller is made for.
[[nodiscard]] suggest::RigAccess access_of_controller(const std::string& file,
                                                      const config::ControllerConfig& controller);

/// The same for a page, which may be read from anywhere: with absolute names.
[[nodiscard]] suggest::RigAccess for_a_page(suggest::RigAccess access);

}  // namespace eha::cli
