// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"
#include "daemon/acquisition/clock.hpp"
#include "daemon/acquisition/run.hpp"
#include "hal/rig.hpp"

namespace eha::record {

/// The outcome of a run that is still going, or whose process died.
inline constexpr std::string_view kInProgress = "in_progress";

/// A run that is about to start.
struct RunDescription {
  const config::RigConfig& rig;
  const config::ExperimentConfig& experiment;
  std::size_t samples_per_repetition = 0;
  acquisition::TimeBase time_base = acquisition::TimeBase::monotonic;
  std::string utc_start;
};

/// What is known before the first tick and goes into raw.ehalog and raw.h5: resolved configuration, ranges,
/// calibration, seeds, versions, and on the monotonic clock the time of day, the host and its kernel. Nothing that
/// differs between two equal runs in virtual time.
[[nodiscard]] nlohmann::ordered_json describe_run(const hal::RigCapabilities& rig, const RunDescription& run);

/// How the run ended, for the manifest and, in short, the journal's end.
[[nodiscard]] nlohmann::ordered_json describe_report(const acquisition::RunReport& report);
[[nodiscard]] nlohmann::ordered_json describe_end(const acquisition::RunReport& report);

/// The manifest of a run about to start: `header`, the time of day and the host.
[[nodiscard]] nlohmann::ordered_json new_manifest(const nlohmann::ordered_json& header, const std::string& utc_start);

/// The manifest of a run of which only the journal is left: what `header` says, null for what it does not.
[[nodiscard]] nlohmann::ordered_json manifest_from_header(const nlohmann::ordered_json& header);

/// Lists every file of the folder but the manifest under `files`, with size and SHA-256, and writes the manifest.
/// What it already says about raw.ehalog and raw.h5 stays.
/// @throws IoError, PermissionError
void write_manifest(const std::filesystem::path& folder, nlohmann::ordered_json& manifest);

/// "2026-11-21T11:01:46Z"
[[nodiscard]] std::string utc_now();

/// @throws DataError  naming `source`, when `name` is no outcome
[[nodiscard]] acquisition::Outcome outcome_from_text(std::string_view name, const std::string& source);

}  // namespace eha::record
