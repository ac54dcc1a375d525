// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/importer/imported_table.hpp"

namespace eha::importer {

/// A column's name without the unit at its end, where the row of units says the same: "Valve" of "Valve V" and
/// "Valve [V]".
[[nodiscard]] std::string name_without_unit(std::string name, const std::string& unit);

/// For columns whose name and row of units say two units: which is taken, and what is wrong if the other is right.
/// @param read  those of the record
[[nodiscard]] std::vector<std::string> remarks_on_two_units(const std::vector<Column>& columns,
                                                            const std::vector<std::size_t>& read,
                                                            const std::filesystem::path& path);

}  // namespace eha::importer
