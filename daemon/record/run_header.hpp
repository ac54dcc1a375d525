// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"
#include "daemon/acquisition/clock.hpp"
#include "hal/rig.hpp"

namespace eha::record {

/// A run that is about to start.
struct RunDescription {
  const config::RigConfig& rig;
  const config::ExperimentConfig& experiment;
  std::size_t samples_per_repetition = 0;
  acquisition::TimeBase time_base = acquisition::TimeBase::monotonic;
  std::string utc_start;
};

/// Makes the header of raw.ehalog and raw.h5, also part of run.json: all facts known before the first tick. It contains
/// the resolved configuration, ranges, calibration, seeds and versions; on the monotonic clock also the time of day,
/// the host and its kernel. In virtual time it contains nothing that differs between two equal runs.
[[nodiscard]] nlohmann::ordered_json describe_run(const hal::RigCapabilities& rig, const RunDescription& run);

/// Returns the header from which a manifest was made (manifest_from_header): its members, in the order of run.json.
[[nodiscard]] nlohmann::ordered_json header_from_manifest(const nlohmann::ordered_json& manifest);

/// Host name and kernel.
[[nodiscard]] std::string host_name();
[[nodiscard]] nlohmann::ordered_json describe_kernel();

/// Members of a header, or of a manifest, that are needed to read a run.
struct RunHeader {
  double sample_period_s = 0.0;  ///< positive
  std::size_t samples_per_repetition = 0;
  std::size_t repetitions = 0;
  std::size_t decimation = 1;  ///< at least 1
  double discard_s = 0.0;
  std::string experiment_text;  ///< content of the experiment file as played; for config::parse_experiment
  std::string rig_text;         ///< content of the rig file as used; for config::parse_rig
};

/// @throws DataError  a member is missing or out of range; names `source` and the member
[[nodiscard]] RunHeader read_run_header(const nlohmann::ordered_json& document, const std::string& source);

/// Returns the rig file's unit of displayed lengths (`units`), from a manifest or header; empty: none.
[[nodiscard]] std::string rig_units(const nlohmann::ordered_json& manifest);

}  // namespace eha::record
