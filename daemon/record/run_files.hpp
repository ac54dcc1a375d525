// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "daemon/record/journal.hpp"

namespace eha::record {

/// Makes raw.h5 and the decimated data of a folder from the intact blocks of its journal. Replaces a damaged header by
/// that in run.json. Reads the journal three times, in constant memory.
/// @returns the journal's facts; the header is never null
/// @throws DataError  the journal's header is damaged, and run.json too; or no journal   @throws IoError,
/// PermissionError
JournalFacts write_files_from_journal(const std::filesystem::path& folder);

/// "data_40ms.csv" for a spacing of 0.04 s.
[[nodiscard]] std::string decimated_file_name(double spacing_s);

/// Seconds as decimal digits, unrounded: 10.04 for 10 040 000 000 ns.
[[nodiscard]] std::string seconds_text(std::int64_t time_ns);

}  // namespace eha::record
