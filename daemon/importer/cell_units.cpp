// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/cell_units.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>

#include "core/unit_names.hpp"
#include "daemon/importer/column_names.hpp"

namespace eha::importer {
namespace {

constexpr std::string_view kBetweenCells = ";\t|,";
constexpr std::string_view kOfNumbers = "0123456789+-.,'";

std::vector<std::string_view> cells_of(std::string_view line, char delimiter) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t end = line.find(delimiter);
    cells.push_back(line.substr(0, end));
    if (end == std::string_view::npos) return cells;
    line.remove_prefix(end + 1);
  }
}

/// The number of a cell and the text behind it.
struct Cell {
  std::string_view number;
  std::string_view unit;
};

std::optional<Cell> cell_of(std::string_view text) {
  const std::size_t begin = text.find_first_of(kOfNumbers);
  if (begin == std::string_view::npos || text.find_first_not_of(" \"") != begin) return std::nullopt;
  std::size_t end = std::min(text.find_first_not_of(kOfNumbers, begin), text.size());
  const bool has_exponent = end + 1 < text.size() && (text[end] == 'e' || text[end] == 'E') &&
                            kOfNumbers.find(text[end + 1]) != std::string_view::npos;
  if (has_exponent) end = std::min(text.find_first_not_of(kOfNumbers, end + 1), text.size());
  std::string_view unit = text.substr(end);
  const std::size_t first = unit.find_first_not_of(" \"");
  const std::size_t last = unit.find_last_not_of(" \"\r");
  unit = first == std::string_view::npos ? std::string_view() : unit.substr(first, last - first + 1);
  if (!unit.empty() && !known_unit(unit)) return std::nullopt;
  return Cell{text.substr(begin, end - begin), unit};
}

/// The unit of each cell; none where some cell is no number with or without a known unit.
std::optional<std::vector<std::string>> units_in(std::string_view line, char delimiter) {
  std::vector<std::string> units;
  for (const std::string_view text : cells_of(line, delimiter)) {
    const std::optional<Cell> cell = cell_of(text);
    if (!cell) return std::nullopt;
    units.emplace_back(cell->unit);
  }
  return units;
}

bool is_of_a_value(const std::string& unit) { return !unit.empty() && !seconds_in(known_unit(unit).value_or("")); }

}  // namespace

std::string CellUnits::without(std::string_view line) const {
  const std::vector<std::string_view> cells = cells_of(line, delimiter);
  if (cells.size() != units.size()) return std::string(line);
  std::string plain;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) plain += delimiter;
    const std::optional<Cell> cell = cell_of(cells[i]);
    plain += cell && cell->unit == units[i] ? cell->number : cells[i];
  }
  return plain;
}

CellUnits cell_units_of(const std::vector<std::string>& lines) {
  for (const char delimiter : kBetweenCells) {
    std::map<std::vector<std::string>, std::size_t> counts;
    for (const std::string& line : lines) {
      const auto units = units_in(line, delimiter);
      if (units && units->size() > 1 && std::any_of(units->begin(), units->end(), is_of_a_value)) ++counts[*units];
    }
    const auto most = std::max_element(counts.begin(), counts.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    if (most != counts.end() && 2 * most->second > lines.size()) return {delimiter, most->first};
  }
  return {};
}

}  // namespace eha::importer
