// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <vector>

#include "daemon/published/published_set.hpp"
#include "ident/record.hpp"

namespace eha::published {

/// Returns every file below a folder in the order of their paths; does not enter linked folders. @throws IoError,
/// PermissionError
[[nodiscard]] std::vector<std::filesystem::path> files_below(const std::filesystem::path& folder);

/// Returns the first of the files that has one of a part's names, ignoring case; empty: none has.
[[nodiscard]] std::filesystem::path found(const Part& part, const std::vector<std::filesystem::path>& files);

/// Reads the rows of a part as they are in the file: fills and leaves out nothing.
/// @param period_s  [s]
/// @throws DataError  the columns or rows are missing, or a value is; IoError, PermissionError
[[nodiscard]] ident::Record read_part(const Part& part, const std::filesystem::path& file, double period_s);

}  // namespace eha::published
