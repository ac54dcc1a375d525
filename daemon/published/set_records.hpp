// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <vector>

#include "daemon/published/published_set.hpp"
#include "ident/record.hpp"

namespace eha::published {

/// Every file below a folder, links followed no further, in the order of their paths. @throws IoError, PermissionError
[[nodiscard]] std::vector<std::filesystem::path> files_below(const std::filesystem::path& folder);

/// The first of the files that has one of a part's names, whatever the case; empty: none has.
[[nodiscard]] std::filesystem::path found(const Part& part, const std::vector<std::filesystem::path>& files);

/// The rows of a part as they stand in the file: nothing is filled or left out.
/// @param period_s  [s]
/// @throws DataError  the file has not the columns or the rows, or a value is missing; IoError, PermissionError
[[nodiscard]] ident::Record read_part(const Part& part, const std::filesystem::path& file, double period_s);

}  // namespace eha::published
