// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <utility>

#include "core/error.hpp"
#include "daemon/eha/command_line.hpp"
#include "daemon/eha/console.hpp"

namespace eha::cli {

/// The options of a command and the function that executes it.
template <typename Options>
struct Request {
  Options options;

  ExitCode operator()(Console& console) const { return execute(options, console); }
};

/// Makes the options of `command`, which its parser fills. They become line.command if the line names the command.
/// @param line  must outlive `command`
template <typename Options>
Options& options_of(CLI::App& command, ParsedLine& line, Options defaults = {}) {
  const auto options = std::make_shared<Options>(std::move(defaults));
  command.callback([options, &command, &line] {
    // CLI11 calls the callback of a subcommand before that of its parent.
    if (command.get_subcommands().empty()) line.command = Request<Options>{*options};
  });
  return *options;
}

}  // namespace eha::cli
