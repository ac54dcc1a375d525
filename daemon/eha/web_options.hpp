// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>

#include "daemon/eha/commands.hpp"

namespace eha::cli {

/// Adds `web`, which fills the command. @param app must not outlive `command`
void add_web(CLI::App& app, WebCommand& command);

}  // namespace eha::cli
