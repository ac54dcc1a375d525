// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "daemon/importer/dialect.hpp"
#include "daemon/importer/imported_table.hpp"
#include "daemon/importer/text_lines.hpp"

// The columns of a file of text, by its header and its first rows.

namespace eha::importer {

/// The columns with names and units of the header. @param text  decodes what is shown
/// @throws DataError  a name holds control characters
[[nodiscard]] std::vector<Column> named_columns(const Dialect& dialect, const TextLines& text,
                                                const std::filesystem::path& path);

/// Adds the values of the first kSampledRows rows, and whether they are numbers or clocks. @param lines  the file's
/// first
void sample_columns(std::vector<Column>& columns, const std::vector<std::string>& lines, const Dialect& dialect,
                    const TextLines& text);

}  // namespace eha::importer
