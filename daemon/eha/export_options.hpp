// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>

#include "daemon/eha/commands.hpp"

namespace eha::cli {

/// Adds the commands that use models and runs elsewhere. @param command  filled by parsing; must outlive it
void add_export(CLI::App& app, ExportCommand& command);
void add_compare(CLI::App& app, CompareCommand& command);
void add_replay(CLI::App& app, ReplayCommand& command);

}  // namespace eha::cli
