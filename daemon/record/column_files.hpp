// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

// For eha-hdf5. Others use record_formats() (record_export.hpp).

namespace eha::record {

/// Numbers of one name; of a single one the name means a scalar.
struct NamedColumn {
  std::string name;  ///< as a variable of every language
  std::string unit;
  std::vector<double> values;
};

/// Passes on every column.
using ColumnSource = std::function<void(const std::function<void(NamedColumn&)>&)>;

/// A MAT file of version 5, a variable for each column. @throws IoError  the library failed
void write_mat_columns(const std::filesystem::path& path, const ColumnSource& source);
/// A dataset for each column, with the attribute `unit`. @throws IoError  the library failed
void write_hdf5_columns(const std::filesystem::path& path, const ColumnSource& source);

}  // namespace eha::record
