// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/control/socket_path.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace eha::cli {

/// Options of a command that moves a rig.
struct DriveOptions {
  std::optional<std::string> rig_file = {};  ///< with `local`; none: default_rig_file()
  std::filesystem::path socket = control::default_socket();
  bool local = false;                     ///< in this process
  bool fast = false;                      ///< virtual time
  bool yes = false;                       ///< move a real actuator without asking
  bool allow_non_realtime = false;        ///< run with ordinary scheduling if necessary
  std::filesystem::path output = "runs";  ///< with `local`: where the run folder goes
};

/// Adds the options that every command has that moves a rig. @returns --local, for options that require or exclude it
CLI::Option* add_drive_options(CLI::App& command, DriveOptions& drive);

}  // namespace eha::cli
