// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/column_text.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "daemon/importer/column_names.hpp"

namespace eha::importer {

std::string_view prefix_of(std::string_view label) {
  const std::size_t at = label.find_last_of("./");
  return at == std::string_view::npos ? std::string_view() : label.substr(0, at + 1);
}

std::string listed(const std::vector<Column>& columns) {
  constexpr std::size_t kMostListed = 12;
  std::string text;
  for (std::size_t i = 0; i < std::min(columns.size(), kMostListed); ++i) {
    text += (i == 0 ? "" : ", ") + described_with_unit(columns, i);
    if (!columns[i].is_number) text += " (text)";
  }
  return columns.size() > kMostListed ? fmt::format("{} and {} more", text, columns.size() - kMostListed) : text;
}

std::string described(const std::vector<Column>& columns, std::size_t index) {
  const std::string& label = columns[index].label;
  if (label.empty()) return fmt::format("{}", index + 1);
  return fmt::format("{} \"{}\"", index + 1, readable(label, kLongestShown));
}

std::string described_with_unit(const std::vector<Column>& columns, std::size_t index) {
  const std::string& unit = columns[index].unit;
  const std::string& label = columns[index].label;
  const bool is_said = unit.empty() || name_and_unit(label).second == unit || label.ends_with(" " + unit);
  return described(columns, index) + (is_said ? "" : fmt::format(" [{}]", readable(unit, kLongestShown)));
}

}  // namespace eha::importer
