// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

namespace eha::importer {

/// Refuses an HDF5 file (a MAT-file 7.3 too) in which a global heap, the place of texts of any length, is no chain of
/// objects that ends with it: HDF5 1.10 follows it without end, or copies what lies behind it.
/// Format: HDF5 File Format Specification 3.0, III.E. Cost O(bytes), mapped, not copied.
/// @param name  the file's, for messages   @throws DataError, IoError
void check_heaps(const std::filesystem::path& path, const std::string& name);

}  // namespace eha::importer
