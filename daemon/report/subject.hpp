// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/identify/fit_table.hpp"
#include "daemon/record/number_table.hpp"
#include "ident/model/model.hpp"
#include "ident/record.hpp"

namespace eha::report {

/// A model and the file that it came from.
struct ReportedModel {
  ident::Model model;
  std::string file;

  /// Grade of its verdict.
  [[nodiscard]] std::optional<ident::FrequencyInterval> usable_band() const {
    return model.verdict ? model.verdict->usable_band : std::nullopt;
  }
};

/// Contents of a report, as read from files.
struct Subject {
  std::string name;                                     ///< of the run, or of the models
  std::optional<nlohmann::ordered_json> manifest = {};  ///< run.json
  std::vector<ReportedModel> models = {};               ///< recommended first, runner-up second, then by verdict
  bool has_recommendation = false;                      ///< models.front() is recommended
  std::string reason = {};                              ///< reason for the recommendation, or for its absence
  std::vector<ident::Model> paper = {};                 ///< by the paper's procedure
  identify::FitTable fit = {};                          ///< empty: no fit.csv
  identify::FitTable paper_fit = {};                    ///< empty: no fit_paper.csv
  std::optional<record::NumberTable> response = {};     ///< frequency_response.csv
  std::optional<ident::Record> record = {};             ///< of a run without fit.csv
  std::vector<std::string> notes = {};                  ///< expected files that are missing

  /// Returns a part of the manifest: part("report", "counters"); null if there is none.
  template <typename... Keys>
  [[nodiscard]] const nlohmann::ordered_json& part(const Keys&... keys) const {
    static const nlohmann::ordered_json kNull;
    const nlohmann::ordered_json* at = manifest ? &*manifest : &kNull;
    for (const char* key : {keys...}) {
      if (!at->is_object() || !at->contains(key)) return kNull;
      at = &(*at)[key];
    }
    return *at;
  }
};

/// Reads a run folder. @throws DataError, IoError, PermissionError  it is no run, or a file in it is damaged
[[nodiscard]] Subject load_run(const std::filesystem::path& folder);

/// Reads model files. Uses fit.csv and frequency_response.csv of their folder, or of the run folder above it, if all
/// are in one folder.
/// @throws ConfigError  no model; DataError, IoError, PermissionError
[[nodiscard]] Subject load_models(const std::vector<std::filesystem::path>& files);

}  // namespace eha::report
