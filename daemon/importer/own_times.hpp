// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "daemon/importer/imported_table.hpp"
#include "daemon/importer/roles.hpp"

// Channels that have a column of times each: "time 1, ch 1, time 2, ch 2".

namespace eha::importer {

/// Refuses channels of which each has a time column and these have no common grid, with a command that makes one where
/// the file is text. @throws DataError
/// @param why  "their steps are 0.01 s and 0.002 s"
[[noreturn]] void refuse_two_grids(const Table& table, const TimedColumn& input, const TimedColumn& output,
                                   const std::string& why, const std::filesystem::path& path, const Options& options);

/// Takes the output's own times, the last column, out of the rows, and checks that they are on the input's grid or
/// beside it by the same part of a step. @returns  how far; empty: on it
/// @throws DataError  there is no common grid
[[nodiscard]] std::string take_output_times(Rows& rows, const Table& table, const Roles& roles,
                                            const std::filesystem::path& path, const Options& options);

}  // namespace eha::importer
