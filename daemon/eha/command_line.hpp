// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "daemon/eha/commands.hpp"
#include "daemon/eha/console.hpp"

namespace eha::cli {

/// What a command line came to.
struct ParsedLine {
  ConsoleOptions console;
  std::optional<Command> command;  ///< none when only a text was asked for
  std::string text;                ///< help or version, for standard output
};

/// Reads the command line. @throws UsageError  something in it is unknown, missing, malformed or out of range
[[nodiscard]] ParsedLine parse_command_line(int argc, const char* const* argv);

/// "eha 0.1.0", then a line for each library with its version, and whether the comedi backend is built in.
[[nodiscard]] std::string version_text();

}  // namespace eha::cli
