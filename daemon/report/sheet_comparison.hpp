// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "daemon/report/subject.hpp"

namespace eha::report {

/// What a report says of a model's valve beside the valve sheet, sentences each.
struct SheetComparison {
  std::string seen;   ///< every value of both, and whether they agree
  std::string to_do;  ///< empty where all agree
};

/// Compares null, dead band, gain ratio and, for a plant that integrates, the gain of a model behind a valve with
/// [following] of the rig file, each with half its 95 % interval. Values differ where they lie further apart than both
/// intervals and a share for the straight lines that the map makes of a rounded valve.
/// @returns none where the rig file has no [following], or no value of both is known
[[nodiscard]] std::optional<SheetComparison> compare_with_sheet(const Subject& subject, const ident::Model& model);

}  // namespace eha::report
