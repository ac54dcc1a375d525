// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/eha/console.hpp"
#include "daemon/identify/identification.hpp"
#include "daemon/record/open_run.hpp"

namespace eha::cli {

/// Writes the report of a fitted run and adds it to the list. A report that fails is a warning, because the models are
/// already written.
void write_report(const record::OpenRun& run, const DisplayUnit& unit, std::vector<std::filesystem::path>& written,
                  const Console& console);

/// Prints the warnings before a fit: reasons for less reliable models of the source, and a long computing time with
/// what shortens it. @param decimation, command  as for identify::size_hint()
void print_warnings(const identify::Source& source, int decimation, const Console& console,
                    const std::function<std::string(int)>& command = {});

/// Prints an identification and the files written, as the short report (with -v all tables too) or as the rest of
/// `document`.
/// @param document  for --json: the command's own members; `models`, `recommendation`, `rounds`, `refused`,
///                  `paper_procedure`, `frequency_response`, `cross_validation`, `files` and `exit_code` are added
void print_identification(const identify::Identification& identification,
                          const std::vector<std::filesystem::path>& written, nlohmann::ordered_json document,
                          const DisplayUnit& unit, const Console& console);

}  // namespace eha::cli
