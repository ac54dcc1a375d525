// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace eha::cli {

/// The path of a run that is named: "latest", "20260101T120000Z-paper" or "runs/latest" that is not in this folder is
/// looked for in ./runs and among the runs of the service, with what follows it (runs/latest/models/io.json).
/// @returns `given` where it is there already, is no run's name, or is nowhere
[[nodiscard]] std::string run_named(const std::string& given);

/// Lets an argument name a run of the service as `eha runs list` does.
CLI::Option* takes_run_name(CLI::Option* option);

}  // namespace eha::cli
