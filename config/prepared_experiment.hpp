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
  Eigen::VectorXd table_V;       ///< one repetition, one voltage a tick [V]
  Eigen::VectorXd predicted_in;  ///< with [hold]: see predicted_displacement() [in]; otherwise empty
};

/// Returns the number of rows at a table's end that hold whole periods: of its tones, or all rows if it is repeated or
/// its lines have no common period that fits. Means over these rows are means of the motion, without the effect of a
/// truncated tone.
/// @param table_rows  ticks of one repetition   @param tick_s  [s]
[[nodiscard]] Eigen::Index periodic_rows(const ExperimentConfig& experiment, Eigen::Index table_rows, double tick_s);

/// Predicts the displacement of an integrating rod by an experiment's table, one value a tick, without its mean and
/// drift over the periodic rows. Integrates the speed that the valve of the rig's [following] gives for the volts, less
/// the mean speed. A hold removes the drift left out here. Cost: one pass. Precondition: the rig has [following].
/// @returns [in]
[[nodiscard]] Eigen::VectorXd predicted_displacement(const ExperimentConfig& experiment, const RigConfig& rig,
                                                     const Eigen::Ref<const Eigen::VectorXd>& table_V);

/// Gain of a hold [V/in] at which an error decays with a time constant of 1 s (`most`) or 1.3 s (`usual`).
struct HoldGains {
  double usual = 0.0;
  double most = 0.0;
};
/// Precondition: the rig has [following].
[[nodiscard]] HoldGains hold_gains(const RigConfig& rig);

/// Returns the least distance from a travel limit at which the rod may be placed [in]: the tick's stopping distance for
/// a rod that has just begun to move, plus 0.04 in.
[[nodiscard]] double placing_margin_in(const RigConfig& rig);

/// Checks an experiment against the rig that plays it: duration a whole number of ticks, tones and bands below the
/// Nyquist frequency of the tick and of the decimated record, decimation a divisor of the samples, and the table of
/// volts within the rig's command limits and slew limit. Cost: one excitation table.
/// @throws ConfigError  every conflict at once, with the place in the experiment file
[[nodiscard]] PreparedExperiment prepare(ExperimentConfig experiment, const RigConfig& rig);

/// Reads an experiment file for a rig; reports errors in the file and conflicts with the rig together.
/// @throws ConfigError, PermissionError as load_experiment and prepare
[[nodiscard]] PreparedExperiment load_prepared_experiment(const std::string& path, const RigConfig& rig);

/// Reads an experiment from text in memory. file_name is used in messages, and with NamedFiles::read also to locate the
/// experiment's own files.
[[nodiscard]] PreparedExperiment parse_prepared_experiment(std::string_view text, const std::string& file_name,
                                                           const RigConfig& rig,
                                                           NamedFiles named_files = NamedFiles::refuse);

}  // namespace eha::config
