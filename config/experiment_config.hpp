// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "config/position.hpp"
#include "config/rig_config.hpp"
#include "ident/estimation/fit_options.hpp"
#include "ident/excitation/excitation_options.hpp"

namespace eha::config {

/// A whole experiment.toml.
struct ExperimentConfig {
  std::string name;
  ident::ExcitationOptions excitation;
  double duration_s = 0.0;  ///< of one repetition [s]
  int repetitions = 1;
  ident::FitOptions fit;  ///< decimation, discarded time, split, procedure, seed
  std::vector<ident::StructureOptions> models;
  ident::AcceptanceLimits acceptance;
  std::string file_name;  ///< as given, for messages
  std::string text;       ///< the file's content as read, for the run's manifest
  PositionMap positions;  ///< where each key stands in the file
};

/// Reads an experiment file and reports everything that is wrong with it at once, in file order.
/// What depends on the tick or on the rig (whole ticks, Nyquist, decimation, peak, slew) is left to check_against().
/// @throws ConfigError      missing, unreadable, not TOML, or wrong
/// @throws PermissionError  the caller may not read it
[[nodiscard]] ExperimentConfig load_experiment(const std::string& path);

/// The same, and check_against() the rig in the same report.
[[nodiscard]] ExperimentConfig load_experiment(const std::string& path, const RigConfig& rig);

/// The same for text already in memory; file_name is used in messages only.
/// @throws ConfigError as load_experiment
[[nodiscard]] ExperimentConfig parse_experiment(std::string_view text, const std::string& file_name);
[[nodiscard]] ExperimentConfig parse_experiment(std::string_view text, const std::string& file_name,
                                                const RigConfig& rig);

/// Holds an experiment against the rig it is to run on: duration a whole number of ticks, tones and bands below the
/// Nyquist frequency of the tick and of the decimated record, decimation a divisor of the samples, and the table of
/// volts itself within the rig's command limits and slew limit. Cost: one excitation table.
/// @throws ConfigError  every conflict at once, with the place in the experiment file
void check_against(const ExperimentConfig& experiment, const RigConfig& rig);

/// Ticks of one repetition. Valid after check_against().
[[nodiscard]] std::size_t samples_per_repetition(const ExperimentConfig& experiment, const RigConfig& rig);

}  // namespace eha::config
