// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/acquisition/run.hpp"
#include "daemon/record/journal.hpp"
#include "ident/validation/recommendation.hpp"

namespace eha::record {

/// Outcome in run.json of a run in progress, or whose process died.
inline constexpr std::string_view kInProgress = "in_progress";

// The manifest run.json as structs. `other` holds the members of the file that its struct does not name. They survive
// reading and writing, in their order.

/// A file of the run folder.
struct FileEntry {
  std::string path;  ///< from the run folder
  std::string sha256;
  nlohmann::ordered_json other = nlohmann::ordered_json::object();  ///< bytes
};

/// A fitted and judged model.
struct ModelEntry {
  std::string name;
  std::string file;  ///< from the run folder
  bool accepted = false;
  std::string grade = {};                 ///< "good", "usable", "rejected"; empty in a manifest of an earlier version
  std::vector<std::string> reasons = {};  ///< for a rejection, then notes
  std::optional<double> estimation_r2_percent = {};
  std::optional<double> seconds = {};  ///< duration of the fit [s]
  std::optional<double> validation_r2_percent = {};
  std::optional<double> validation_r2_percent_offset_reestimated = {};
  std::optional<std::vector<double>> usable_band_Hz = {};  ///< lowest and highest frequency
  nlohmann::ordered_json other = nlohmann::ordered_json::object();
};

/// The result of a run's identification.
struct IdentificationEntry {
  bool accepted = false;  ///< at least one model is
  std::vector<ModelEntry> models;
  std::optional<ident::Recommendation> recommendation = {};
  std::optional<nlohmann::ordered_json> paper_procedure = {};  ///< models in the form of their files
  std::string error = {};                                      ///< reason for no result; empty otherwise
  nlohmann::ordered_json other = nlohmann::ordered_json::object();
};

/// The part of run.json's `report` that `eha` shows; describe_report() writes all of it.
struct ReportEntry {
  std::string description;  ///< of the end; empty when the run completed
  std::string write_error;  ///< of a file that could not be written; empty without
  acquisition::LoopCounters counters;
};

/// The result of recover_run().
struct RecoveryEntry {
  std::string utc;
  std::uint64_t rows = 0;  ///< intact ones
  std::uint64_t torn_bytes = 0;
  nlohmann::ordered_json end = nullptr;  ///< outcome in the journal, if it was written
  std::vector<JournalGap> gaps = {};     ///< damage within the journal
};

/// run.json.
struct Manifest {
  std::optional<acquisition::Outcome> outcome = {};  ///< none: in progress
  std::optional<std::string> utc_end = {};
  std::vector<FileEntry> files = {};
  std::optional<ReportEntry> report = {};
  std::optional<IdentificationEntry> identification = {};
  std::optional<RecoveryEntry> recovery = {};
  nlohmann::ordered_json other = nlohmann::ordered_json::object();  ///< the run's header among them
};

/// The outcome as run.json has it: "completed", ..., or "in_progress".
[[nodiscard]] std::string_view outcome_text(const Manifest& manifest) noexcept;
/// Whether an outcome, as run.json has it, is that of a run that ended as wanted.
[[nodiscard]] bool is_whole(std::string_view outcome) noexcept;

/// Key of run.json: the first fault of a recovered run by its rows, where the journal's end was not written.
inline constexpr const char* kFaultOfRows = "fault_of_rows";

/// The fault that ended a run, in the form of describe_report(): by the report or, of a recovered run, by the journal's
/// end; where that was not written by its rows, which have the "cause" and no figures. Null without a fault.
[[nodiscard]] nlohmann::ordered_json fault_of(const Manifest& manifest);

/// As acquisition::reading_jumped() of fault_of(). Rows have no speed, so that every velocity_limit of them counts.
[[nodiscard]] bool reading_jumped(const Manifest& manifest);

/// Whether fault_of() is one that acquisition::names_motion().
[[nodiscard]] bool missed_motion(const Manifest& manifest);

/// The description of a run's end without what to do, where the record shows the cause: "no_motion at 4.1 s: a closed
/// loop drove the rod, and it moved 0.1 in where 0.2 in were due". Lost records, an output that is not safe and a dead
/// guard stay.
[[nodiscard]] std::string without_remedy(const std::string& description);

/// @throws DataError  `name` is no outcome; names `source`
[[nodiscard]] acquisition::Outcome outcome_from_text(std::string_view name, const std::string& source);

/// Purpose of a run.
enum class Purpose { models, placing, valve_sheet, tracking };

/// Returns the purpose from the experiment in the manifest; models if the manifest does not state it.
[[nodiscard]] Purpose purpose_of(const Manifest& manifest);

/// Returns the models that were fitted to the run; none before the fit.
[[nodiscard]] std::vector<ModelEntry> models_of(const Manifest& manifest);

/// Writes the members in the order of run.json.
[[nodiscard]] nlohmann::ordered_json to_json(const Manifest& manifest);
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<ModelEntry>& models);

/// {"model", "reason", "runner_up", "needs_fresh_record"}; model and runner_up are null if there is none. Where they
/// apply, "is_unclear", "is_lag_or_delay", "accepted_instead". The same in
/// run.json and in the output of `eha fit --json`.
[[nodiscard]] nlohmann::ordered_json to_json(const ident::Recommendation& recommendation);

/// @throws DataError  not a manifest, or a member has the wrong type; names `source`
[[nodiscard]] Manifest manifest_from_json(nlohmann::ordered_json document, const std::string& source);
/// Reads the list of models of a manifest or of an answer of ehad. @throws DataError  as manifest_from_json
[[nodiscard]] std::vector<ModelEntry> models_from_json(const nlohmann::ordered_json& list, const std::string& source);

/// Makes the manifest of a run about to start on this host: `header`, the time of day, the host and its kernel.
[[nodiscard]] Manifest new_manifest(const nlohmann::ordered_json& header, const std::string& utc_start);

/// Makes the manifest of a run of which only the journal exists: the members of `header`, null for missing ones.
[[nodiscard]] Manifest manifest_from_header(const nlohmann::ordered_json& header);

/// Adds the report of a run that has ended to its manifest, and the time.
void put_report(Manifest& manifest, const acquisition::RunReport& report, const std::string& write_error);

/// @throws IoError, PermissionError; DataError  as manifest_from_json
[[nodiscard]] Manifest read_manifest(const std::filesystem::path& folder);

/// Lists every file of the folder except the manifest under `files`, with size and SHA-256, and replaces the manifest
/// atomically. Entries of raw.ehalog and raw.h5 are kept: these files must not change after the run, and hashing them
/// again would hide a change. @throws IoError, PermissionError
void write_manifest(const std::filesystem::path& folder, Manifest& manifest);

/// Replaces `identification` in a run's manifest and updates its list of files. @throws as read_manifest,
/// write_manifest
void write_identification(const std::filesystem::path& folder, IdentificationEntry identification);

/// "2026-11-21T11:01:46Z"
[[nodiscard]] std::string utc_now();

}  // namespace eha::record
