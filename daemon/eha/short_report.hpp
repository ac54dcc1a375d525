// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "core/display_unit.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/identify/identification.hpp"
#include "daemon/record/manifest.hpp"

namespace eha::cli {

/// Result of an identification, by this process or read from a run.
struct Answer {
  std::vector<ident::Model> models = {};
  std::vector<ident::Model> paper = {};  ///< by the paper's procedure, for comparison
  ident::Recommendation recommendation = {};
};

[[nodiscard]] Answer answer_of(const identify::Identification& identification);

/// Reads the models of a run; nothing if it has not been fitted.
/// @throws IoError, PermissionError, ConfigError  a model file is missing or damaged
[[nodiscard]] Answer answer_of_run(const std::filesystem::path& folder, const record::Manifest& manifest);

/// How much of the reasons to write: the first one in full and two more, or all of them (-v).
enum class Reasons { first, all };

/// Writes at most 80 columns: the recommended model with its equation, its fit and largest error on validation data,
/// its usable band, its verdict and the reasons; then one line a model. Empty without models.
[[nodiscard]] std::string short_report(const Answer& answer, const DisplayUnit& unit, Reasons reasons = Reasons::first);

/// The first lines of that: the recommended model without reasons. Empty if none is recommended.
[[nodiscard]] std::string answer_text(const Answer& answer, const DisplayUnit& unit);

/// Prints the short report of a run and its files. If it cannot be read, prints the reason as a warning and the list of
/// models in the manifest. @returns whether the run has models
bool print_answer(const std::filesystem::path& folder, const record::Manifest& manifest, const Console& console);

/// "4 rejected, 2 not needed" of the models that are not accepted; empty if all are.
[[nodiscard]] std::string words_of_rejected(const std::vector<ident::Model>& models);

/// The recommendation in full, where the short report may cut its reasons.
[[nodiscard]] std::string recommendation_text(const Answer& answer, const DisplayUnit& unit);

}  // namespace eha::cli
