// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "config/prepared_experiment.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/rehearsal/rehearsal.hpp"

namespace eha::cli {

/// Returns the least predicted distance to a travel limit that 95 % of the rehearsed rods keep [in]; negative beyond
/// it.
[[nodiscard]] std::optional<double> margin_of(const std::optional<Rehearsal>& rehearsal, const config::RigConfig& rig);

/// "drifts +0.0123 in/s"; "does not drift" where the figure has no digit but 0.
[[nodiscard]] std::string drift_text(double drift_per_s, const std::string& unit);

[[nodiscard]] nlohmann::ordered_json to_json(const Rehearsal& rehearsal);

/// Describes the predicted motion of the rod: "rehearsed with the rig's valve: the rod stays within ...".
[[nodiscard]] std::string sentence_on(const Rehearsal& rehearsal, const config::RigConfig& rig, const Console& console);

/// Returns advice for an experiment that probably reaches a limit.
enum class TravelRisk { refuse, accept };

/// The process that plays an experiment, as far as it matters for a move before it.
enum class Player { service, local };

/// Whether the rod stands where the rig file says each time anew, so that no move before a run helps it: the simulated
/// rig of a local run, which is opened for each.
[[nodiscard]] bool begins_anew(const config::RigConfig& rig, Player player);

/// A rehearsed experiment, and where the rod stands before it.
struct Rehearsed {
  const config::PreparedExperiment& experiment;
  const config::RigConfig& rig;
  double place_in;
  const std::optional<Rehearsal>& rehearsal;
  Player player = Player::service;
};

/// Whether a rehearsal is warned of: one draw in twenty or more reaches a limit.
[[nodiscard]] bool is_at_risk(const std::optional<Rehearsal>& rehearsal);

/// `eha goto` to mid-travel, from where the experiment stays clear of the limits; empty where that does not help, or
/// where the rod begins anew. Rehearses once more.
[[nodiscard]] std::string move_before(const Rehearsed& rehearsed, const Console& console);

/// Warns if one draw in twenty reaches a limit, with what helps: a move to mid-travel where the experiment stays clear
/// from there ([start] in the experiment where the rod begins anew). Nothing if the experiment could not be rehearsed.
/// @throws ConfigError  half of the draws do, and the risk is not accepted
void judge_travel(const Rehearsed& rehearsed, const std::string& experiment_file, TravelRisk risk,
                  const Console& console);

/// A placing that was asked for from one place does not begin at another: half an inch up may have become an inch down.
/// @throws ConfigError
void require_place_to_begin(const config::ExperimentConfig& experiment, double place_in,
                            const std::string& experiment_file, const DisplayUnit& unit);

/// Refuses to play from beyond a travel limit, from where only a move to a place is allowed.
/// @throws ConfigError  gives the command of that move
void require_within_travel(const config::ExperimentConfig& experiment, const config::RigConfig& rig, double place_in,
                           const std::string& experiment_file, const Console& console, Player player = Player::service);

/// Warns, before any motion, of an experiment whose record will have too few rows to estimate a model.
void warn_if_not_fittable(const config::ExperimentConfig& experiment, const config::RigConfig& rig,
                          const std::string& experiment_file, const Console& console);

/// Warns of an experiment that cannot be rehearsed, because the rig file has no [following]. @returns whether it did
bool warn_if_not_rehearsed(const config::ExperimentConfig& experiment, const config::RigConfig& rig,
                           const std::string& experiment_file, const Console& console);

/// Says that the rod moves a little and back before the experiment; see config::shows_motion_first().
void say_motion_shown_first(const config::ExperimentConfig& experiment, const config::RigConfig& rig,
                            const Console& console);

/// Warns of an experiment whose volts hardly leave the valve's dead band.
void warn_of_little_motion(const Rehearsed& rehearsed, const std::string& experiment_file, const Console& console);

/// Prints the result of the rehearsal and judges it, before a run. @throws ConfigError  as judge_travel
void report_rehearsal(const Rehearsed& rehearsed, const std::string& experiment_file, TravelRisk risk,
                      const Console& console);

/// Why a run reached a limit, where its record shows it: a drift, with the offset that stops it, or the sensor; empty
/// if the files in its folder do not determine it.
[[nodiscard]] std::string cause_of_trip(const std::string& run_folder, const Console& console);

/// Reports the drift, and the offset that stops it, for a run that reached a limit, from the files in its folder;
/// nothing if they do not determine it.
/// @returns whether the rod was driven by another valve than that of [following], which may be missing, or by a leak,
/// which a valve sheet shows
bool explain_trip(const std::string& run_folder, const Console& console);

}  // namespace eha::cli
