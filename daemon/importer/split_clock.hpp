// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "daemon/importer/dialect.hpp"
#include "daemon/importer/imported_table.hpp"

namespace eha::importer {

/// Between commas "14:03:12,040" is two fields, of which the header names one. Seconds of the first `most` rows where
/// the first two columns are such a clock; empty for other files.
[[nodiscard]] std::vector<double> sample_of_split_clock(const std::vector<std::string>& lines, const Dialect& dialect,
                                                        const std::vector<Column>& columns, std::size_t most);

}  // namespace eha::importer
