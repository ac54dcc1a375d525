// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/report/subject.hpp"

namespace eha::report {

/// Its name in a run folder.
inline constexpr std::string_view kReportFile = "report.html";

/// A report as one HTML page: no other file, no script, nothing from the network. It prints on A4.
struct Page {
  std::string html;
  std::vector<std::string> missing = {};  ///< plots that could not be drawn, one sentence each
};

/// Cost: some 0.2 s, nearly all of it gnuplot's. A missing or failing gnuplot leaves the page without the plots.
[[nodiscard]] Page page_of(const Subject& subject);

/// Writes RUN/report.html and lists it in run.json. @returns the plots that are missing, as Page
/// @throws DataError, IoError, PermissionError  as load_run(), or the folder cannot be written
std::vector<std::string> write_into_run(const std::filesystem::path& run_folder);

}  // namespace eha::report
