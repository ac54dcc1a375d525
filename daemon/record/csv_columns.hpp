// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace eha::record {

/// The numbers of a CSV file, not yet interpreted.
struct CsvColumns {
  std::vector<std::string> names;           ///< of the header row, all columns
  std::vector<std::vector<double>> values;  ///< [wanted column][row], finite
  int time_decimals = 0;     ///< most digits after the point in the first column (negative: none, and trailing zeros)
  int time_significant = 0;  ///< most significant digits in the first column
  std::size_t header_line = 0;
  /// (row, line) where the distance between the two changes, ascending.
  std::vector<std::pair<std::size_t, std::size_t>> line_marks;

  [[nodiscard]] std::size_t rows() const { return values.empty() ? 0 : values.front().size(); }
  /// Line (from 1) of the file that holds a row (from 0). Cost O(log marks).
  [[nodiscard]] std::size_t line_of(std::size_t row) const;
};

/// Which columns of the file are read; the others need not be numbers.
enum class WantedColumns { all, first_and_last };

/// Reads a CSV file with libcsv. @throws DataError, IoError, PermissionError as record_csv.hpp says
[[nodiscard]] CsvColumns read_csv_columns(const std::filesystem::path& path, WantedColumns wanted);

}  // namespace eha::record
