// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/acquisition/run.hpp"
#include "daemon/acquisition/tick_record.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/open_run.hpp"
#include "ident/record.hpp"

namespace eha::record {

/// File names in a run folder; `data_40ms.csv` is named after its spacing.
inline constexpr std::string_view kManifestFile = "run.json";
inline constexpr std::string_view kJournalFile = "raw.ehalog";
inline constexpr std::string_view kRawFile = "raw.h5";
inline constexpr std::string_view kModelsFolder = "models";
inline constexpr std::string_view kRejectedFolder = "rejected";  ///< in kModelsFolder
inline constexpr std::string_view kLatestLink = "latest";        ///< beside the run folders

/// A run read back from its folder.
struct LoadedRun {
  std::filesystem::path folder;
  OpenRun opened;  ///< the same, held
  Manifest manifest;
  acquisition::Outcome outcome = acquisition::Outcome::completed;
  /// Every experiment row: applied volts in, displacement out; row 0 is the excitation's first tick, at 0 s.
  ident::Record record;
  std::size_t samples_per_repetition = 0;
  std::size_t repetitions = 0;
  std::string experiment_text;  ///< content of the experiment file as played; for config::parse_experiment
  std::string rig_text;         ///< content of the rig file as used; for config::parse_rig
};

/// Creates `<UTC time>-<name>` under `runs_folder` (created too), with an empty models folder; a second run within one
/// second gets a number after its name. @param name  letters, digits, '-', '_' and '.', anything else becomes '-'
/// @throws PermissionError, IoError
[[nodiscard]] std::filesystem::path create_run_folder(const std::filesystem::path& runs_folder, std::string_view name);

/// Whether a path is a folder that holds a manifest or a journal.
[[nodiscard]] bool is_run_folder(const std::filesystem::path& path);

/// Treatment of a run that another process is still recording.
enum class StillGoing {
  refuse,
  read,  ///< return its rows so far, like those of a completed run
};

/// Reads a run back from raw.h5, or from the journal if there is no raw.h5.
/// @throws DataError  a file was changed since the run (SHA-256), is damaged, or holds no experiment row
/// @throws IoError, PermissionError  a file is missing or cannot be read
[[nodiscard]] LoadedRun read_run(const OpenRun& run, StillGoing still_going = StillGoing::refuse);
/// Opens it before. A folder's `latest` link may be given.
[[nodiscard]] LoadedRun read_run(const std::filesystem::path& folder, StillGoing still_going = StillGoing::refuse);

/// Reads every row as recorded, ramps included, from the same files with the same errors.
[[nodiscard]] std::vector<acquisition::TickRecord> read_ticks(const std::filesystem::path& folder);

/// The run folders under `runs_folder`, oldest first; none when it does not exist.
/// @throws IoError, PermissionError
[[nodiscard]] std::vector<std::filesystem::path> list_runs(const std::filesystem::path& runs_folder);

/// What of another kind stands where the link `latest` beside the run folder would stand; empty for nothing.
[[nodiscard]] std::string what_stands_for_latest(const OpenRun& run);

/// Moves the link `latest` beside the run folder to the run, atomically. Only for a run with an accepted model
/// and without a reason_against_latest(). What is no link stays, see what_stands_for_latest().
/// @throws IoError, PermissionError
void publish_latest(const OpenRun& run);

}  // namespace eha::record
