// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/terminal_table.hpp"

#include <algorithm>
#include <cstddef>

#include "core/terminal_text.hpp"

namespace eha::cli {
namespace {

/// Number of characters of UTF-8 text: the bytes that are not continuation bytes.
std::size_t characters(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](unsigned char c) { return (c & 0xC0U) != 0x80U; }));
}

}  // namespace

std::string text_table(const std::vector<Column>& columns, const std::vector<std::vector<std::string>>& rows) {
  // A name with line breaks would begin lines outside of the table.
  std::vector<std::vector<std::string>> cells = rows;
  for (auto& row : cells) std::transform(row.begin(), row.end(), row.begin(), one_line);
  std::vector<std::size_t> widths;
  for (const Column& column : columns) widths.push_back(characters(column.title));
  for (const auto& row : cells) {
    for (std::size_t i = 0; i < columns.size(); ++i) widths[i] = std::max(widths[i], characters(row[i]));
  }
  std::string out;
  const auto add_line = [&](auto&& cell) {
    std::string line;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const std::string text = cell(i);
      const std::string blanks(widths[i] - characters(text), ' ');
      line += columns[i].align == Align::left ? text + blanks : blanks + text;
      line += "  ";
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  };
  add_line([&](std::size_t i) { return columns[i].title; });
  add_line([&](std::size_t i) { return std::string(widths[i], '-'); });
  for (const auto& row : cells) add_line([&](std::size_t i) { return row[i]; });
  return out;
}

}  // namespace eha::cli
