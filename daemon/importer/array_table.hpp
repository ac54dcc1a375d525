// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "daemon/importer/table.hpp"

namespace eha::importer {

/// Values that one file may hold, so that a wrong file does not fill the memory: 1.6 GB.
inline constexpr std::size_t kMostValues = 200'000'000;

/// Columns that one matrix may have.
inline constexpr std::size_t kMostMatrixColumns = 64;

/// A named array of numbers in a file, one-dimensional or a column of a matrix.
struct ArrayColumn {
  std::string name;  ///< "rec.u", "/run/voltage", "X(:,2)"
  std::string unit;  ///< empty: as the name says
  std::vector<double> values;
  bool is_single = false;  ///< of 32-bit floating-point numbers, so only seven digits are known
};

/// A table of arrays. Those of one value are left out.
/// @param guess  "MAT-file 7.3"   @param remark  the reason why other contents are not offered; may be empty
/// @throws DataError  no array has two values
[[nodiscard]] std::unique_ptr<Table> table_of_arrays(const std::filesystem::path& path, const std::string& guess,
                                                     std::vector<ArrayColumn> arrays, const std::string& remark);

/// Opens a MAT-file of version 4, 5 or 7.3 with matio: numeric arrays, and those in structs (`rec.u`, nested too).
/// @throws DataError  damaged, or without numbers; IoError
[[nodiscard]] std::unique_ptr<Table> open_mat(const std::filesystem::path& path, const Options& options);

/// Opens an HDF5 file: one- and two-dimensional datasets of numbers and compounds of numbers, in any group; an
/// attribute `unit` or `units` is the unit. @throws DataError  damaged, or without numbers, or the raw.h5 of a run;
/// IoError
[[nodiscard]] std::unique_ptr<Table> open_hdf5(const std::filesystem::path& path, const Options& options);

}  // namespace eha::importer
