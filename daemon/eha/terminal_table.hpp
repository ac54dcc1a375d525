// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace eha::cli {

enum class Align { left, right };

/// A column of a table.
struct Column {
  std::string title;
  Align align = Align::left;
};

/// Writes a table as text: titles, a rule, rows. Columns are separated by two blanks and as wide as their widest cell
/// in characters (UTF-8); no trailing blanks. @param rows  each as long as `columns`
[[nodiscard]] std::string text_table(const std::vector<Column>& columns,
                                     const std::vector<std::vector<std::string>>& rows);

}  // namespace eha::cli
