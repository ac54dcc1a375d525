// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>

#include "daemon/eha/commands.hpp"

namespace eha::cli {

/// Adds the options that every command has that moves a rig. @returns --local, for options that need or exclude it
CLI::Option* add_drive_options(CLI::App& command, DriveOptions& drive);

}  // namespace eha::cli
