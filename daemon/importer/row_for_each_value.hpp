// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "daemon/importer/imported_table.hpp"

namespace eha::importer {

/// The end of a refusal: databases write a row for each value, with a column that names its channel. The command that
/// puts the channels beside each other; empty where no column names channels.
[[nodiscard]] std::string row_for_each_value(const Table& table, std::size_t time, std::size_t value,
                                             const std::filesystem::path& path, const Options& options);

}  // namespace eha::importer
