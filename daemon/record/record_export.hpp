// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "ident/record.hpp"

namespace eha::record {

/// An export format of a record, with every row. The columns have the names of a record CSV: time_s, then the input and
/// the output with their units as suffixes (voltage_V, displacement_in).
struct RecordFormat {
  std::string_view name;    ///< of --format
  std::string_view ending;  ///< of a file
  std::string_view what;    ///< for --help
  /// Writes the file under its name complete or not at all.
  /// @throws IoError, PermissionError
  void (*write)(const ident::Record& record, const std::filesystem::path& path);
};

/// csv: eha-record(5). mat: MAT file of version 5, hdf5: datasets with the attribute `unit`; in both one column a
/// variable and the scalar sample_period_s.
[[nodiscard]] std::span<const RecordFormat> record_formats();

/// Writes a record as CSV text, passed on in pieces. Cost O(N).
void write_record_csv(const ident::Record& record, const std::function<void(std::string_view)>& write);

}  // namespace eha::record
