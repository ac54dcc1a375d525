// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>

#include "daemon/eha/commands.hpp"

namespace eha::cli {

/// Add the commands fit, simulate and validate, which fill the structs during parsing.
void add_fit(CLI::App& app, FitCommand& fit);
void add_import(CLI::App& app, ImportCommand& import);
void add_simulate(CLI::App& app, SimulateCommand& simulate);
void add_validate(CLI::App& app, ValidateCommand& validate);

}  // namespace eha::cli
