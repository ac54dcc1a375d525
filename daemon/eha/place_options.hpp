// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>

#include "daemon/eha/commands.hpp"

namespace eha::cli {

/// `goto` and `jog`.
struct PlaceCommands {
  PlaceCommand go_to;
  PlaceCommand jog;
};

void add_place_commands(CLI::App& app, PlaceCommands& commands);

}  // namespace eha::cli
