// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/importer/imported_table.hpp"
#include "daemon/importer/roles.hpp"

namespace eha::importer {

/// The place of each row on an even grid, from 0, by stamps that come early or late: a row lies one place behind the
/// one before, and farther where the clock went on meanwhile and stays ahead. Empty where no row is missing, or the
/// times fall or repeat. Cost O(N).
[[nodiscard]] std::vector<std::size_t> places_on_grid(const std::vector<double>& time_s);

/// What a column of times says where --period replaces it.
struct ReplacedClock {
  std::vector<std::size_t> places;   ///< of the rows, as places_on_grid(); empty: no row is missing
  std::vector<std::string> remarks;  ///< that it contradicts the period, and that rows are missing
};

/// Reads the file's times a second time. A file without such a column, or one that does not tell them, says nothing.
/// @param roles  with a period in place of the time  @param selection  the rows, of which `rows` were read
[[nodiscard]] ReplacedClock replaced_clock(const Table& table, const Roles& roles, const Selection& selection,
                                           std::size_t rows, const std::filesystem::path& path, const Options& options);

}  // namespace eha::importer
