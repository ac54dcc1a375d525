// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "daemon/eha/commands.hpp"
#include "daemon/eha/console.hpp"

namespace eha::cli {

/// A parsed command line.
struct ParsedLine {
  ConsoleOptions console;
  std::optional<Command> command;  ///< none for --help, --version and completion
  std::string text;                ///< help or version, for standard output
};

/// Reads the command line. @throws UsageError  an option or argument is unknown, missing, malformed or out of range
[[nodiscard]] ParsedLine parse_command_line(int argc, const char* const* argv);

}  // namespace eha::cli
