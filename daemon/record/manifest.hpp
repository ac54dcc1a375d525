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

namespace eha::record {

/// The outcome in run.json of a run that is still going, or whose process died.
inline constexpr std::string_view kInProgress = "in_progress";

// The manifest run.json as structs. `other` holds the members that a file had and its struct does not name, or all of
// them; they survive reading and writing, in their order.

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
  std::vector<std::string> reasons;  ///< why it was rejected, or what to know
  std::optional<double> estimation_r2_percent = {};
  std::optional<double> seconds = {};  ///< that the fit took
  std::optional<double> validation_r2_percent = {};
  std::optional<double> validation_r2_percent_offset_reestimated = {};
  nlohmann::ordered_json other = nlohmann::ordered_json::object();
};

/// What the identification of a run came to.
struct IdentificationEntry {
  bool accepted = false;  ///< at least one model is
  std::vector<ModelEntry> models;
  std::optional<nlohmann::ordered_json> paper_procedure = {};  ///< models in the form of their files
  std::string error = {};                                      ///< why there is none; empty when there is
  nlohmann::ordered_json other = nlohmann::ordered_json::object();
};

/// What run.json's `report` says of the run for people; all of it is describe_report().
struct ReportEntry {
  std::string description;  ///< of the end; empty when the run completed
  std::string write_error;  ///< of a file that could not be written; empty without
  acquisition::LoopCounters counters;
};

/// What recover_run did.
struct RecoveryEntry {
  std::string utc;
  std::uint64_t rows = 0;
  std::uint64_t torn_bytes = 0;
  nlohmann::ordered_json end = nullptr;  ///< the journal's, if it had been written
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

/// @throws DataError  `name` is no outcome; names `source`
[[nodiscard]] acquisition::Outcome outcome_from_text(std::string_view name, const std::string& source);

/// The models that were fitted to the run; none before.
[[nodiscard]] std::vector<ModelEntry> models_of(const Manifest& manifest);

/// The members in the order of run.json.
[[nodiscard]] nlohmann::ordered_json to_json(const Manifest& manifest);
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<ModelEntry>& models);

/// @throws DataError  not a manifest, or a member has the wrong type; names `source`
[[nodiscard]] Manifest manifest_from_json(nlohmann::ordered_json document, const std::string& source);
/// Reads the list of models of a manifest or of an answer of ehad. @throws DataError  as manifest_from_json
[[nodiscard]] std::vector<ModelEntry> models_from_json(const nlohmann::ordered_json& list, const std::string& source);

/// The manifest of a run about to start on this host: `header`, the time of day, the host and its kernel.
[[nodiscard]] Manifest new_manifest(const nlohmann::ordered_json& header, const std::string& utc_start);

/// The manifest of a run of which only the journal is left: the members of `header`, null for those it lacks.
[[nodiscard]] Manifest manifest_from_header(const nlohmann::ordered_json& header);

/// Puts the report of a run that has ended into its manifest, and the time.
void put_report(Manifest& manifest, const acquisition::RunReport& report, const std::string& write_error);

/// @throws IoError, PermissionError; DataError  as manifest_from_json
[[nodiscard]] Manifest read_manifest(const std::filesystem::path& folder);

/// Lists every file of the folder but the manifest under `files`, with size and SHA-256, and replaces the manifest
/// atomically. Entries of raw.ehalog and raw.h5 stay as they are: these never change once the run is over, and hashing
/// them again would hide a change. @throws IoError, PermissionError
void write_manifest(const std::filesystem::path& folder, Manifest& manifest);

/// Replaces `identification` in a run's manifest and lists its files anew. @throws as read_manifest, write_manifest
void write_identification(const std::filesystem::path& folder, IdentificationEntry identification);

/// "2026-11-21T11:01:46Z"
[[nodiscard]] std::string utc_now();

}  // namespace eha::record
