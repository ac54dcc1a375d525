// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace eha::importer {

/// Units that stand behind the numbers in the cells: "0.02 s;1.25 V;74.9 mm".
struct CellUnits {
  char delimiter = ';';
  std::vector<std::string> units = {};  ///< of each column as written; empty where its cells have none

  [[nodiscard]] bool empty() const { return units.empty(); }
  /// A line without them. A cell with another unit stays as it is, so that it is no number.
  [[nodiscard]] std::string without(std::string_view line) const;
};

/// What most lines say; empty where no cell but those of a time has a unit. Cost O(characters) a delimiter tried.
[[nodiscard]] CellUnits cell_units_of(const std::vector<std::string>& lines);

}  // namespace eha::importer
