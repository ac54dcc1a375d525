// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "config/prepared_experiment.hpp"
#include "config/rig_config.hpp"

namespace eha {

/// Chance of a trip from which on an experiment is not played unless its user says so.
inline constexpr double kRefusedChanceOfTrip = 0.5;

/// Predicted motion of an integrating rod in an experiment, by the valve in [following].
struct Rehearsal {
  double lowest_in = 0.0;       ///< that 95 % of the draws stay above [in]
  double highest_in = 0.0;      ///< that 95 % of the draws stay below [in]
  double drift_in_per_s = 0.0;  ///< mean speed of the rod, the valve being as [following] has it; 0 with a hold
  double chance_of_trip =
      0.0;  ///< share of the draws that reach a travel or velocity limit, stopping distance included
  /// Of the excitation, that would stop the drift; none with a hold, beyond the command limits, where the rod would
  /// reach a limit all the same, or where another offset would change what the experiment is for (a step).
  std::optional<double> still_offset_V = {};
  bool offset_has_no_room = false;  ///< one would stop the drift, but the command limits leave no room for it
};

/// Plays an experiment on rods y' = v(u), v the valve of the rig's [following] with null, dead band and gains drawn
/// from their uncertainty, config::valve_uncertainty(); with [hold] the loop is played too. Steps of 5 ms; spool, oil
/// and friction are left out.
/// @param start_in  where the rod stands; [start] of the experiment goes first
/// @returns none without [following], or when the experiment plays nothing
/// Cost: 200 draws of 50 s take about 30 ms. Thread-safe; equal arguments give equal results.
[[nodiscard]] std::optional<Rehearsal> rehearse(const config::PreparedExperiment& experiment,
                                                const config::RigConfig& rig, double start_in, std::uint64_t seed = 1);

/// What moved the rod on the average of a run, beyond its tones.
struct Drift {
  double rate_in_per_s = 0.0;           ///< mean speed over whole periods of the excitation
  std::optional<double> offset_V = {};  ///< of the excitation that would stop it; none within the command limits
};

/// Computes the drift of a run from its displacement and its volts: the part that the valve of [following] predicts
/// from the whole table, and the rest.
/// @param displacement_in  rows in state running, one a tick, from the first; at least 2
/// @returns none without [following], with a hold, when the experiment plays nothing, or where its excitation moves the
/// rod to one side by itself (a step)
[[nodiscard]] std::optional<Drift> drift_of(const config::PreparedExperiment& experiment, const config::RigConfig& rig,
                                            const Eigen::Ref<const Eigen::VectorXd>& displacement_in);

}  // namespace eha
