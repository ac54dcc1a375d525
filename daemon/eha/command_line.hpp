// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/eha/wrong_file.hpp"

namespace eha::cli {

/// A parsed command line.
struct ParsedLine {
  ConsoleOptions console = {};
  /// Executes the command. Returns the exit code of a legitimate outcome, throws eha::Error for broken input or
  /// environment. Empty for --help and --version.
  std::function<ExitCode(Console&)> command = {};
  std::string text = {};                       ///< help or version, for standard output
  std::string as_given = {};                   ///< the line, quoted for a shell
  std::vector<NamedFile> named_files = {};     ///< of the command
  std::vector<std::string> notes = {};         ///< on its arguments, to be said first
  std::vector<std::string> after_dashes = {};  ///< the arguments after `--` of `eha batch`
};

/// Reads the command line. @throws UsageError  an option or argument is unknown, missing, malformed or out of range
[[nodiscard]] ParsedLine parse_command_line(int argc, const char* const* argv);

}  // namespace eha::cli
