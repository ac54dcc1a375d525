// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/display_unit.hpp"
#include "daemon/identify/fit_table.hpp"
#include "daemon/identify/trip_cause.hpp"
#include "daemon/record/number_table.hpp"
#include "daemon/record/open_run.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "daemon/suggest/commands.hpp"
#include "ident/model/model.hpp"
#include "ident/record.hpp"
#include "ident/validation/first_step.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/valve/leak.hpp"

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

/// The recommended one of all models of a record, where a report is of others.
struct RecommendedBeside {
  std::string model;
  std::string word;  ///< ident::verdict_word()
  std::string file;
};

/// Contents of a report, as read from files.
struct Subject {
  std::string name;                                     ///< of the run, or of the models
  std::string folder = {};                              ///< of the run, absolute; empty: of model files
  std::string written = {};                             ///< when the newest of the model files was, UTC; of a run empty
  std::optional<nlohmann::ordered_json> manifest = {};  ///< run.json
  std::vector<ReportedModel> models = {};               ///< in the order of ident::table_order()
  bool has_recommendation = false;                      ///< models.front() is recommended
  std::optional<RecommendedBeside> beside = {};         ///< of model files: of all of their record in their folder
  std::string runner_up = {};                           ///< name of the recommended model's; empty: none
  std::size_t pictured_models = 2;                      ///< the pictures show up to so many
  std::string reason = {};                              ///< of the recommendation, or of its absence
  std::vector<ident::Model> paper = {};                 ///< by the paper's procedure
  identify::FitTable fit = {};                          ///< empty: no fit.csv
  identify::FitTable paper_fit = {};                    ///< empty: no fit_paper.csv
  std::optional<record::NumberTable> response = {};     ///< frequency_response.csv
  std::optional<ident::Record> record = {};             ///< of a run without fit.csv, or that a fault ended
  identify::FitTable track = {};                        ///< of a controller's trial, its reference as the only model
  std::vector<std::string> trial_changes = {};    ///< what a controller's trial that a fault ended showed of the valve
  std::optional<identify::TripCause> cause = {};  ///< of a limit that ended the run, where the record shows it
  std::string trial_stood = {};                   ///< a trial that stood under volts when it ended; empty: it did not
  std::optional<ident::Leak> leak = {};           ///< of the rig, by the valve sheet; none is known otherwise
  std::optional<record::MeasuredValve> sheet = {};  ///< of the rig, by the newest valve sheet beside the run
  ident::SheetSays sheet_says = ident::SheetSays::nothing;
  DisplayUnit unit = DisplayUnit("in");  ///< of lengths
  std::vector<std::string> notes = {};   ///< files that should be there and are not

  /// How the rig of the run is reached; none for model files.
  [[nodiscard]] std::optional<suggest::RigAccess> access() const;

  /// Whether the report is of model files that a user named, and not of a run.
  [[nodiscard]] bool is_of_files() const noexcept { return !manifest; }

  /// What stands before the use of the models, as terminal and page have it too.
  [[nodiscard]] ident::NextStep next_step() const;

  /// When a fault ended the run, in times of its record; none where none did.
  [[nodiscard]] std::optional<double> trip_s() const;

  /// Where in `fit` the part begins that estimated nothing of the first model drawn; none where there is no such part.
  [[nodiscard]] std::optional<double> split_s() const;

  /// Whether the output of the record never changes, so that no model was fitted.
  [[nodiscard]] bool is_constant() const;

  /// The models of the pictures: the recommended one and its runner-up; without a runner-up the first two.
  [[nodiscard]] std::vector<const ReportedModel*> pictured() const;

  /// A part of the manifest: part("report", "counters"); null where there is none.
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
[[nodiscard]] Subject load_run(const record::OpenRun& run);

/// Reads model files. Uses fit.csv and frequency_response.csv of their folder, or of the run folder above it, and the
/// other models of the same record there, if all are in one folder.
/// @throws ConfigError  no model; DataError, IoError, PermissionError
[[nodiscard]] Subject load_models(const std::vector<std::filesystem::path>& files);

}  // namespace eha::report
