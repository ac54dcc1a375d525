// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "core/error.hpp"
#include "daemon/eha/console.hpp"

namespace eha::cli {

/// Whether valve_sheet.json and report.html are written into the run folder, or are there already.
enum class SheetFiles { write, keep };

/// Computes the valve sheet of a completed run of [characterise] and prints it with the lines for rig and experiment
/// files.
/// @throws DataError, IoError, PermissionError  as sheet::sheet_of_run; the folder cannot be written
ExitCode show_valve_sheet(const std::filesystem::path& folder, SheetFiles files, const Console& console);

}  // namespace eha::cli
