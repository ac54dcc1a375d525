// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "daemon/eha/command_line.hpp"

namespace eha::cli {

/// A run that a name stands for.
struct NamedRun {
  std::string path;       ///< as given if it exists, is no run's name, or is not found
  std::string note = {};  ///< which of two runs of one name was taken; empty: there is one
};

/// Of which newer run the link "latest" is to be told. It names the last run with an accepted model.
enum class Newer {
  of_models,       ///< one that ended early, or whose models were not accepted
  of_any_purpose,  ///< a whole trial, placing or characterisation, too
};

/// Resolves the path of a run. "latest", "20260101T120000Z-paper" or "runs/latest" that is not in the working directory
/// is searched in ./runs and among the runs of the service, with the rest of the path (runs/latest/models/io.json);
/// another name in ./runs only.
[[nodiscard]] NamedRun run_named(const std::string& given, const std::filesystem::path& socket,
                                 Newer newer = Newer::of_models);

/// Returns the folder of the service's runs; empty without a service that answers.
[[nodiscard]] std::filesystem::path run_folder_of_service(const std::filesystem::path& socket);

/// Allows an argument to name a run of the service as `eha runs list` does. What is to be said of it becomes a note of
/// the line.
CLI::Option* takes_run_name(CLI::Option* option, ParsedLine& line, Newer newer = Newer::of_models);

}  // namespace eha::cli
