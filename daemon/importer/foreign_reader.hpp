// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <filesystem>
#include <string_view>

#include "core/os/file_descriptor.hpp"
#include "daemon/importer/array_table.hpp"

// MAT-files and HDF5 are read by the program eha-reader (daemon/record/confined_reader.hpp). Text needs no such
// process: what it takes is proportional to the file, and its reader is the project's own.

namespace eha::importer {

/// Reads a file in a process of its own.
/// @param kind  a name of kForeignReaders
/// @throws DataError  damaged, or it needs more than its limits   @throws IoError, PermissionError
[[nodiscard]] Arrays read_foreign(std::string_view kind, const std::filesystem::path& path);

/// The first sheet of a workbook (.xlsx) as CSV text in a file without a name: by the program xlsx2csv, which
/// eha-reader becomes. Dates are numbers of days, as the workbook has them.
/// @returns none where xlsx2csv is not installed   @throws DataError  no workbook, or it needs more than its limits
[[nodiscard]] os::FileDescriptor read_workbook(const std::filesystem::path& path);
inline constexpr const char* kWorkbookProgram = "/usr/bin/xlsx2csv";
inline constexpr std::string_view kWorkbook = "workbook";  ///< the kind, for eha-reader

/// The kinds that eha-reader reads.
struct ForeignReader {
  std::string_view kind;
  Arrays (*read)(const std::filesystem::path& path, const std::string& name);
};
inline constexpr std::array kForeignReaders{ForeignReader{"mat", read_mat}, ForeignReader{"hdf5", read_hdf5}};

// What passes from eha-reader to the process that started it. `name` is the file's, for messages.

/// The answer where there is no refusal (record::send_refusal). @throws IoError
void send_arrays(int descriptor, const Arrays& arrays);

}  // namespace eha::importer
