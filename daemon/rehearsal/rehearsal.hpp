// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "config/prepared_experiment.hpp"
#include "config/rig_config.hpp"

namespace eha {

/// Probability of a trip above which an experiment is not played unless its user accepts the risk.
inline constexpr double kRefusedChanceOfTrip = 0.5;

/// Probability of a trip from which on a rehearsed experiment is warned of.
inline constexpr double kWarnedChanceOfTrip = 0.05;

/// Assumed position of a rod that has not been read: the initial one of a simulated rig, otherwise mid-travel [in].
[[nodiscard]] double start_of(const config::RigConfig& rig);

/// Predicted motion of an integrating rod in an experiment, by the valve in [following].
struct Rehearsal {
  double lowest_in = 0.0;       ///< 95 % of the draws stay above it [in]
  double highest_in = 0.0;      ///< 95 % of the draws stay below it [in]
  double drift_in_per_s = 0.0;  ///< mean speed of the rod for the undrawn valve of [following]; 0 with a hold
  double chance_of_trip =
      0.0;  ///< share of the draws that reach a travel or velocity limit, stopping distance included
  /// Offset of the excitation that would stop the drift. None with a hold, beyond the command limits, if the rod would
  /// still reach a limit, or if another offset would change the purpose of the experiment (a step).
  std::optional<double> still_offset_V = {};
  bool offset_has_no_room = false;  ///< such an offset exists, but the command limits exclude it
};

/// Plays an experiment on rods y' = v(u), v the valve of the rig's [following] with null, dead band and gains drawn
/// from their uncertainty, config::valve_uncertainty(); with [hold] the loop is included, and so are the ramps at the
/// slew limit before and after the table. Uses steps of 5 ms; neglects spool, oil and friction.
/// @param start_in  position of the rod; [start] of the experiment takes precedence
/// @returns none without [following], or if the experiment plays nothing
/// Cost: 200 draws of 50 s take about 30 ms. Thread-safe; equal arguments give equal results.
[[nodiscard]] std::optional<Rehearsal> rehearse(const config::PreparedExperiment& experiment,
                                                const config::RigConfig& rig, double start_in, std::uint64_t seed = 1);

/// Whether an experiment without a start of its own is rehearsed and stays clear of the limits from mid-travel: fewer
/// than kWarnedChanceOfTrip of the draws reach one. Cost as rehearse().
[[nodiscard]] bool is_clear_from_mid_travel(const config::PreparedExperiment& experiment, const config::RigConfig& rig);

/// Returns how far the volts go from the valve's null where its dead band is most of that, so that they hardly move the
/// rod [V]; none where they go farther, and without [following].
[[nodiscard]] std::optional<double> reach_within_dead_band(const config::PreparedExperiment& experiment,
                                                           const config::RigConfig& rig);

/// Mean motion of the rod in a run, beyond its tones.
struct Drift {
  double rate_in_per_s = 0.0;           ///< mean speed over whole periods of the excitation
  std::optional<double> offset_V = {};  ///< offset of the excitation that would stop it; none within the command limits
};

/// Computes the drift of a run from its displacement and its volts: the part that the valve of [following] predicts
/// from the whole table, and the rest.
/// @param displacement_in  rows in state running, one a tick, from the first; at least 2
/// @returns none without [following], with a hold, if the experiment plays nothing, or if its excitation moves the rod
/// to one side by design (a step)
[[nodiscard]] std::optional<Drift> drift_of(const config::PreparedExperiment& experiment, const config::RigConfig& rig,
                                            const Eigen::Ref<const Eigen::VectorXd>& displacement_in);

}  // namespace eha
