// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/acquisition/tick_record.hpp"
#include "daemon/record/raw_file.hpp"

// For the programs that load HDF5. Others use write_raw_file (raw_file.hpp) and read_raw_rows (confined_reader.hpp).

namespace eha::record {

/// Writes the datasets that raw_file.hpp describes. Constant memory.
/// @param header  ASCII: Octave does not load a text marked as UTF-8, nor the datasets after it
/// @param rows    how many records `source` hands over
/// @throws IoError  the library failed
void write_raw_hdf5(const std::filesystem::path& path, const std::string& header, std::uint64_t rows,
                    std::int64_t zero_ns, const RecordSource& source);

/// A raw record read back.
struct RawFile {
  nlohmann::ordered_json header;
  std::vector<acquisition::TickRecord> records;
};

/// HDF5 trusts the file's content.
/// @param name  the file's, for messages; empty: its path
/// @throws IoError, PermissionError  cannot be read; DataError  not such a file, or damaged
[[nodiscard]] RawFile read_raw_file(const std::filesystem::path& path, const std::string& name = {});

}  // namespace eha::record
