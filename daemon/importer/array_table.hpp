// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "daemon/importer/imported_table.hpp"

namespace eha::importer {

/// Values that one file may hold, so that a wrong file does not fill the memory: 1.6 GB.
inline constexpr std::size_t kMostValues = 200'000'000;

/// Columns that one matrix may have.
inline constexpr std::size_t kMostMatrixColumns = 64;

/// Structs within each other.
inline constexpr int kDeepest = 8;

/// A named array of numbers in a file, one-dimensional or a column of a matrix.
struct ArrayColumn {
  std::string name;  ///< "rec.u", "/run/voltage", "X(:,2)"
  std::string unit;  ///< empty: as the name says
  std::vector<double> values;
  bool is_single = false;  ///< of 32-bit floating-point numbers, so only seven digits are known
};

/// The arrays of numbers in a file.
struct Arrays {
  std::string guess;  ///< "MAT-file 7.3"
  std::vector<ArrayColumn> columns;
  std::string remark;  ///< the reason why other contents are not offered; may be empty
};

/// A table of arrays. Those of one value are no columns; named Ts or so, one is the sample period. @throws DataError no
/// array has two values
[[nodiscard]] std::unique_ptr<Table> table_of_arrays(const std::filesystem::path& path, Arrays arrays);

// The readers run in a process of their own (foreign_reader.hpp). `path` is what they open, `name` is for messages.

/// Whether a file of `file_bytes` can hold that much: compression makes at most 1032 of one byte (zlib).
[[nodiscard]] bool can_hold(std::uint64_t file_bytes, std::uint64_t elements, std::uint64_t element_bytes);

/// Reads a MAT-file of version 4, 5 or 7.3 with matio: numeric arrays, and those in structs (`rec.u`, nested too).
/// @throws DataError  damaged, or declares more than it can hold
[[nodiscard]] Arrays read_mat(const std::filesystem::path& path, const std::string& name);

/// Reads an HDF5 file: one- and two-dimensional datasets of numbers and compounds of numbers, in any group; an
/// attribute `unit` or `units` is the unit. @throws DataError  damaged, too deep, or declares more than it can hold
[[nodiscard]] Arrays read_hdf5(const std::filesystem::path& path, const std::string& name);

}  // namespace eha::importer
