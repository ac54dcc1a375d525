// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/display_unit.hpp"
#include "daemon/identify/comparison.hpp"
#include "daemon/identify/scored_model.hpp"
#include "daemon/report/comparison_page.hpp"

namespace eha::cli {

/// What `eha compare` answers, as a document, on the terminal, as a picture and as a page. Points into the models that
/// it was made of.
struct Compared {
  nlohmann::ordered_json document;
  std::string text;
  std::vector<std::pair<std::string, const ident::Model*>> models;  ///< for the picture
  report::ComparisonFindings findings;
  std::vector<report::ComparedSubject> subjects;  ///< for the report
  /// The record whose plant has changed, of several the last one; none: no change is shown. Counts the sources.
  std::optional<std::size_t> changed_source = {};
  bool changes_valve = false;  ///< with a parameter of the valve among those that changed, or where its sheet says more
};

/// A comparison in the unit for people.
[[nodiscard]] identify::RunComparison converted(identify::RunComparison comparison, const DisplayUnit& unit);
/// The same for scores. @param output_unit  of the record
[[nodiscard]] identify::ScoredModel converted(identify::ScoredModel scored, const DisplayUnit& unit,
                                              const std::string& output_unit);

/// @param sources  of the runs, in their order
[[nodiscard]] Compared described(const identify::RunComparison& comparison,
                                 const std::vector<identify::Source>& sources);
/// @param models, files  of the scores, in their order   @param source  the record
[[nodiscard]] Compared described(const std::vector<identify::ScoredModel>& scored,
                                 const std::vector<ident::Model>& models, const std::vector<std::string>& files,
                                 const identify::Source& source);
/// Of models alone.
[[nodiscard]] Compared described(const std::vector<ident::Model>& models, const std::vector<std::string>& files);

}  // namespace eha::cli
