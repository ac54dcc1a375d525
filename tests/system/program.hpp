// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace eha::test {

/// Exit code and output of a program.
struct Ended {
  int code = -1;  ///< exit code; 128 + the signal's number when a signal ended it
  std::string out;
  std::string err;
};

/// Runs the built `eha` to its end, with an empty standard input, in the folder `at`. @throws std::runtime_error
/// @param output  a file or device that standard output goes to; none: Ended::out
[[nodiscard]] Ended run_eha(const std::vector<std::string>& arguments, const std::filesystem::path& at,
                            const std::filesystem::path& output = {});

/// Starts `eha`, waits until `ready` is true (asked again and again while the program lives), sends it a signal, and
/// waits for its end. @throws std::runtime_error  the program ended before it was ready
[[nodiscard]] Ended interrupt_eha(const std::vector<std::string>& arguments, const std::filesystem::path& at,
                                  const std::function<bool()>& ready, int signal);

/// Standard output of a command line of the shell, empty when it cannot be run.
[[nodiscard]] std::string output_of_shell(const std::string& command);

/// Number of lines of a text that begin with `beginning`.
[[nodiscard]] std::size_t lines_beginning_with(const std::string& text, std::string_view beginning);

/// The source tree's shipped file, such as "config/rigs/sim.toml".
[[nodiscard]] std::filesystem::path source_file(std::string_view name);

}  // namespace eha::test
