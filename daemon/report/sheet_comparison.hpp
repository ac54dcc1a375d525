// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "daemon/report/subject.hpp"

namespace eha::report {

/// Comparison of a model's valve with [following] of the rig file, which is called the valve sheet where a measurement
/// wrote it, in sentences.
struct SheetComparison {
  std::string seen;   ///< every value of both, and whether they agree
  std::string to_do;  ///< empty if all agree
  /// "The rig is not as its valve sheet says: ..."; empty if at most the null differs, which moves with the oil.
  std::string headline;
};

/// Compares null, dead band, gain ratio and, for a plant that integrates, the gain of a model behind a valve with
/// [following] of the rig file, each with half its 95 % interval. Values differ if their distance exceeds both
/// intervals and a share for the map's straight lines, which approximate a rounded valve.
/// @returns none if the rig file has no [following], or no value is known in both
[[nodiscard]] std::optional<SheetComparison> compare_with_sheet(const Subject& subject, const ident::Model& model);

}  // namespace eha::report
