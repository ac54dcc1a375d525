// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>

#include "daemon/eha/commands.hpp"

namespace eha::cli {

/// Adds `report` and `plot`, which fill their structs.
void add_report(CLI::App& app, ReportCommand& report);
void add_plot(CLI::App& app, PlotCommand& plot);

}  // namespace eha::cli
