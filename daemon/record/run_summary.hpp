// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/record/manifest.hpp"

namespace eha::record {

/// A line of a list of runs.
struct RunSummary {
  std::string folder;
  std::string outcome;                ///< as in run.json; "unreadable" where that cannot be read
  std::string fault = {};             ///< its cause, such as "travel_limit"; empty without
  Purpose purpose = Purpose::models;  ///< purpose of the run
  double recorded_s = 0.0;            ///< from the first to the last tick; 0: not known
  std::vector<ModelEntry> models = {};
  std::string recommended = {};  ///< name of the recommended model; empty where none is
};

[[nodiscard]] RunSummary summary_of(const std::string& folder, const Manifest& manifest);

/// Returns why a run does not become `latest`, whatever its models: it was stopped or tripped before half of its
/// experiment was recorded. Empty for the others, and for one whose length run.json does not tell.
[[nodiscard]] std::string reason_against_latest(const Manifest& manifest);

/// {"folder", "outcome", "fault", "purpose", "recorded_s", "models", "recommended"}; fault and recommended are null
/// without one.
[[nodiscard]] nlohmann::ordered_json to_json(const RunSummary& summary);
/// Gives members that an earlier version left out their defaults. @throws DataError  names `source`
[[nodiscard]] RunSummary summary_from_json(nlohmann::ordered_json json, const std::string& source);

}  // namespace eha::record
