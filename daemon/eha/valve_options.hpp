// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>

#include "daemon/eha/commands.hpp"

namespace eha::cli {

/// Adds `eha characterise`.
void add_characterise(CLI::App& app, CharacteriseCommand& characterise);

/// Adds `eha calibrate`.
void add_calibrate(CLI::App& app, CalibrateCommand& calibrate);

}  // namespace eha::cli
