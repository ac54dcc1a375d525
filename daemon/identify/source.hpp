// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/experiment_config.hpp"
#include "daemon/record/run_folder.hpp"
#include "ident/record.hpp"

namespace eha::identify {

/// A record to identify from, and its origin.
struct Source {
  std::string name;  ///< as given on the command line, for messages
  ident::Record record;
  std::optional<config::ExperimentConfig> experiment;  ///< the run's, or the named one
  std::optional<std::filesystem::path> run_folder;     ///< when it is a run
  /// Rows of one repetition, of the run or as the named experiment would play it; 0 when unknown.
  std::size_t repetition_samples = 0;
  acquisition::Outcome outcome = acquisition::Outcome::completed;
  std::size_t interpolated_rows = 0;  ///< as record::LoadedRun; 0 for a CSV record
};

/// The share of the rows that are interpolated, not measured [%].
[[nodiscard]] double interpolated_percent(const Source& source);

/// Reasons why models of this source are less reliable: an incomplete run, rows that were not measured. One sentence
/// each.
[[nodiscard]] std::vector<std::string> warnings(const Source& source);

/// Reads a run folder or a CSV record.
/// @param experiment_file  replaces the run's own experiment
/// @throws DataError, IoError, PermissionError, ConfigError  as record::read_run, read_record_csv, load_experiment
[[nodiscard]] Source load_source(const std::string& name, const std::optional<std::string>& experiment_file);

}  // namespace eha::identify
