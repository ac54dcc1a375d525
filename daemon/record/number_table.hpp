// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace eha::record {

/// A CSV file written by the project: a header row, then numbers; lines that begin with # are comments.
struct NumberTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;  ///< one a name, of one length; NaN where a field is empty

  [[nodiscard]] std::size_t rows() const { return columns.empty() ? 0 : columns.front().size(); }
  /// Returns the column of that name; none: nullptr.
  [[nodiscard]] const std::vector<double>* find(std::string_view name) const;
};

/// @throws DataError        a field is no number, a row has another number of fields, or there is no row: "FILE:LINE:
/// ..."
/// @throws IoError, PermissionError
/// Cost O(size); some 20 million numbers a second.
[[nodiscard]] NumberTable read_number_table(const std::filesystem::path& path);

}  // namespace eha::record
