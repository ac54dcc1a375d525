// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/display_unit.hpp"
#include "daemon/record/open_run.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/subject.hpp"

namespace eha::report {

/// Name of the report in a run folder.
inline constexpr std::string_view kReportFile = "report.html";

/// The report of a run or of models. Cost as assembled().
[[nodiscard]] Page page_of(const Subject& subject);

/// Writes RUN/report.html, lengths in the unit, and lists it in run.json. @returns the missing plots, as Page
/// @throws DataError, IoError, PermissionError  as load_run(), or the folder cannot be written
std::vector<std::string> write_into_run(const record::OpenRun& run, const DisplayUnit& unit);

}  // namespace eha::report
