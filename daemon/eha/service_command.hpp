// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/control/socket_path.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace eha::cli {

class Console;

/// A method of ehad-protocol(7): status, arm, disarm, stop, metrics, reload, queue, hold, release, move, cancel, ack,
/// remove.
struct ServiceCommand {
  std::string method = {};
  std::filesystem::path socket = control::default_socket();
  std::vector<std::int64_t> entries = {};  ///< of cancel, hold, release and move; none: all of the user
  std::int64_t to = 0;                     ///< of move: position from 1; 0: `by` says
  std::int64_t by = 0;                     ///< of move: positions towards the end
  std::string run = {};                    ///< of ack and remove: its folder or the folder's name
  bool yes = false;                        ///< of remove, and of arm by root: without asking
  bool watch = false;                      ///< of status: repeatedly
  std::optional<std::string> ruler = {};   ///< of arm: where a ruler shows the rod
};

[[nodiscard]] ExitCode execute(const ServiceCommand& command, Console& console);

/// --socket PATH.
CLI::Option* add_socket_option(CLI::App& app, std::filesystem::path& socket);
CLI::Option* add_socket_option(CLI::App& app, std::optional<std::filesystem::path>& socket);

/// The numbers of queued experiments.
CLI::Option* add_entries(CLI::App& app, ServiceCommand& service, const char* help);

}  // namespace eha::cli
