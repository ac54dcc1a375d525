// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "daemon/importer/dialect.hpp"
#include "daemon/importer/imported_table.hpp"

namespace eha::importer {

/// Whether the rows of a text begin with the newest one, as loggers export them: a column that tells the time, by its
/// name, as a clock or as one of minutes, falls, and none rises.
/// @param columns  sampled   @param lines  of the file, from its first
[[nodiscard]] bool is_newest_first(const std::vector<Column>& columns, const std::vector<std::string>& lines,
                                   const Dialect& dialect);

/// Turns the rows round. @param from_first  that column counts from its first row, as a clock does: from 0 again
void turn_round(std::vector<double>& values, bool from_first);

}  // namespace eha::importer
