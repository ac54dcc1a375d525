// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"

namespace eha::config {

/// An experiment that is valid for a rig, with its table of volts. Made once for each run.
struct PreparedExperiment {
  ExperimentConfig config;
  Eigen::VectorXd table_V;  ///< one repetition, one voltage a tick [V]
};

/// Checks an experiment against the rig that plays it: duration a whole number of ticks, tones and bands below the
/// Nyquist frequency of the tick and of the decimated record, decimation a divisor of the samples, and the table of
/// volts within the rig's command limits and slew limit. Cost: one excitation table.
/// @throws ConfigError  every conflict at once, with the place in the experiment file
[[nodiscard]] PreparedExperiment prepare(ExperimentConfig experiment, const RigConfig& rig);

/// Reads an experiment file for a rig; reports errors in the file and conflicts with the rig together.
/// @throws ConfigError, PermissionError as load_experiment and prepare
[[nodiscard]] PreparedExperiment load_prepared_experiment(const std::string& path, const RigConfig& rig);

/// The same for text already in memory; file_name is used in messages, and with NamedFiles::read as the place from
/// which the experiment's own files are found.
[[nodiscard]] PreparedExperiment parse_prepared_experiment(std::string_view text, const std::string& file_name,
                                                           const RigConfig& rig,
                                                           NamedFiles named_files = NamedFiles::refuse);

}  // namespace eha::config
