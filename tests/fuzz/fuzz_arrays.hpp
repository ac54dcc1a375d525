// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

#include "core/error.hpp"
#include "daemon/importer/array_table.hpp"
#include "tests/fuzz/memory_file.hpp"
#include "tests/fuzz/require.hpp"

namespace eha::fuzz {

/// What eha-reader does with a file, and what the process that started it does with the answer: columns of a record, or
/// a refusal. Names in it are made readable where the answer arrives.
inline void check_arrays(importer::Arrays (*read)(const std::filesystem::path&, const std::string&),
                         const std::uint8_t* data, std::size_t size) {
  const MemoryFile file(data, size);
  try {
    importer::Arrays arrays = read(file.path(), file.path().string());
    std::size_t values = 0;
    for (const importer::ArrayColumn& column : arrays.columns) values += column.values.size();
    require(values <= importer::kMostValues, "a file holds no more numbers than it may");
    const auto table = importer::table_of_arrays(file.path(), std::move(arrays));
    require(!table->columns().empty(), "a table has a column");
  } catch (const DataError& error) {
    require(std::string_view(error.what()).starts_with(file.path().string()), "a message begins with the file's name");
  }
}

}  // namespace eha::fuzz
