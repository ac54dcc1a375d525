// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace eha::batch {

/// A record of a batch, as named in its manifest.
struct Record {
  std::string id;  ///< "0007-pump": its place in the list from 1, and its name; a folder of this name holds its result
  std::string source;  ///< run folder or file with a record; as listed, relative to the working directory
  std::string sha256;  ///< of the file, or of the run's manifest; empty if it cannot be read

  bool operator==(const Record&) const = default;
};

/// A named run, or an item of a named folder, that is no record.
struct Skipped {
  std::string source;
  std::string why;  ///< "no ending of a record (.csv, ...)": alike for all of one kind
};

struct FoundRecords {
  std::vector<Record> records;
  std::vector<Skipped> skipped;
};

/// Returns the records that a command names, each once, in the order of the names; those of a folder by time where all
/// are runs, else by name; and what of them is none. Runs that placed the rod, measured the valve or followed a
/// reference are none.
/// @param sources  each one of these: a run folder; a file with a record; a folder of both; a list, which is a text
/// file whose name ends in ".list", with one path a line relative to its folder, lines with # left out
/// @throws UsageError  no record
/// @throws IoError, PermissionError  a folder or a list cannot be read
[[nodiscard]] FoundRecords records_of(const std::vector<std::string>& sources);

}  // namespace eha::batch
