// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace eha::importer {

/// Rows of a signal that hold a code for a missing value.
struct MissingCode {
  double value = 0.0;
  std::vector<std::size_t> rows = {};  ///< from 0, ascending
  std::size_t dropouts = 0;            ///< places where the signal drops to the value and comes back; 0: a code
};

/// Finds numbers that programs write where nothing was measured: only nines (-999, 9999, -99999), or 1e29 and beyond
/// (SCPI's 9.91e37, the greatest float). Such a number is a code where it is far outside the range of the others.
/// Values that are not finite are passed over. Cost O(N) a code.
[[nodiscard]] std::vector<MissingCode> missing_codes(std::span<const double> values);

/// Finds where a measured signal drops to exactly 0 for four rows or more, and comes back, both within one row and by
/// three times as much as it moves between any two other rows: a lost signal. Up to three rows are lone_rows(). None
/// where half of the rows or more are so, and where a part at either end is. Cost O(N).
[[nodiscard]] std::optional<MissingCode> dropouts(std::span<const double> values);

/// "40 rows of the output hold -9999, a code for missing values". @param column  "the output"
[[nodiscard]] std::string missing_code_text(const MissingCode& code, const std::string& column);

}  // namespace eha::importer
