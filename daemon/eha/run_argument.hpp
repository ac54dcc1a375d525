// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace eha::cli {

/// Resolves the path of a run. "latest", "20260101T120000Z-paper" or "runs/latest" that is not in the working directory
/// is searched in ./runs and among the runs of the service, with the rest of the path (runs/latest/models/io.json).
/// @returns `given` if it exists, is no run's name, or is not found
[[nodiscard]] std::string run_named(const std::string& given);

/// Returns what run_named() has to say: which of two runs of one name was taken. Empties the list.
[[nodiscard]] std::vector<std::string> taken_notes_on_runs();

/// Allows an argument to name a run of the service as `eha runs list` does.
CLI::Option* takes_run_name(CLI::Option* option);

}  // namespace eha::cli
