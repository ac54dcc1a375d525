// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/importer/column_names.hpp"
#include "daemon/importer/imported_table.hpp"

namespace eha::importer {

/// The column of times, and those that tell the time too.
struct TimeChoice {
  std::optional<std::size_t> column = {};  ///< none: the file states its period
  std::string note = {};                   ///< what the others say, for the line of guesses; empty without others
  /// Of channels that have a time column each ("time 1, ch 1, time 2, ch 2"): all of these, ascending. The first one
  /// is `column`. Empty for other files.
  std::vector<std::size_t> of_channels = {};
};

/// Finds the column of times: by name and unit, else one that rises evenly, else a clock ("14:03:12.040") whose rows
/// differ. Of several that agree the finest regular one is taken.
/// @param hints  of each column   @param taken  columns that the options name
/// @throws DataError  none, or two that contradict one another, or a clock that is coarser than the rows: with commands
[[nodiscard]] TimeChoice find_time_column(Table& table, const std::filesystem::path& path, const Options& options,
                                          const std::vector<Hints>& hints,
                                          const std::vector<std::optional<std::size_t>>& taken);

/// A spreadsheet's dates are days since 1899, MATLAB's since the year 0. As seconds such a record would be sampled
/// faster than a rig is. @throws DataError  such a column, with the commands for days and for seconds
void refuse_days(Table& table, std::size_t column, const std::filesystem::path& path, const Options& options);

}  // namespace eha::importer
