// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/display_unit.hpp"
#include "daemon/report/page.hpp"
#include "daemon/sheet/run_sheet.hpp"

namespace eha::sheet {

/// A quantity of two valve sheets, in the unit that is shown.
struct ComparedQuantity {
  std::string name;
  std::string unit;
  ident::Measured before;
  ident::Measured after;
  double joint = 0.0;                  ///< half width of the difference's interval, joint with those of all others
  [[nodiscard]] bool changed() const;  ///< the difference is beyond it
};

/// Comparison of valve sheets with the first one: null, edges of the dead band, gains and drift.
struct ComparedSheets {
  std::string heading;  ///< "The valve has changed: null, gain extending"
  std::vector<std::string> sentences = {};
  std::vector<std::vector<ComparedQuantity>> quantities = {};  ///< of each sheet beside the first
  std::vector<std::string> names = {};                         ///< run folder and rig of each
  /// Whose valve the sentences say to measure again: the last sheet that leaks or has changed, else the last one.
  std::size_t measured_again = 0;
  suggest::RigAccess rig = {};  ///< that of this sheet, for a page
};

/// Compares sheets with the first. The intervals are joint: the probability that any quantity of any sheet is said to
/// have changed although none did is at most ident::kFalseAlarm (Bonferroni), as their errors depend on each other.
/// @param sheets  at least two
/// @param unit    of lengths in the result
[[nodiscard]] ComparedSheets compare_sheets(const std::vector<RunSheet>& sheets, const DisplayUnit& unit);

/// A row for each quantity: name, before, after, difference, joint interval, unit, and whether it changed.
[[nodiscard]] std::vector<std::vector<std::string>> rows_of(const std::vector<ComparedQuantity>& quantities);

/// Schema eha-sheet-comparison/1; lengths in the unit of the quantities.
[[nodiscard]] nlohmann::ordered_json to_json(const ComparedSheets& compared);

/// The comparison as a page: its sentences, then a table for each sheet.
[[nodiscard]] report::Page page_of(const ComparedSheets& compared);

}  // namespace eha::sheet
