// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/rehearsal_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/measured_check.hpp"
#include "config/valve_estimate.hpp"
#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "core/shell_word.hpp"
#include "daemon/eha/rod_text.hpp"
#include "daemon/identify/trip_cause.hpp"
#include "daemon/place/place_controller.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_header.hpp"
#include "hal/backends/backend.hpp"
#include "ident/estimation/fit_rows.hpp"

namespace eha::cli {
namespace {

constexpr double kSurelyEnough_rows = 1e6;
/// Share of the travel beside a limit where a rod is close to it.
constexpr double kCloseShare = 0.05;
/// Too small for an offset: a tenth of an inch in a hundred seconds.
constexpr double kSmallDrift_in_per_s = 0.001;

/// `eha goto` to mid-travel with the options of the player.
std::string move_to_middle(const config::RigConfig& rig, Player player, const DisplayUnit& unit) {
  const std::string move = goto_middle({rig.limits.travel_min_in, rig.limits.travel_max_in}, unit);
  return player == Player::local ? fmt::format("{} --local --rig {}", move, shell_word(rig.file_name)) : move;
}

/// The move to mid-travel from where the experiment stays clear of the limits; empty where none helps, or where the
/// experiment moves the rod to its own start.
std::string move_that_helps(const Rehearsed& rehearsed, const Console& console) {
  if (!is_clear_from_mid_travel(rehearsed.experiment, rehearsed.rig)) return {};
  const double middle_in = rehearsed.rig.limits.mid_travel_in();
  const DisplayUnit unit = console.unit(rehearsed.rig.units);
  const std::string stands =
      fmt::format("the rod stands at {:.3f} {}, and from mid-travel the experiment stays clear of them",
                  unit.factor("in") * rehearsed.place_in, unit.of("in"));
  if (!begins_anew(rehearsed.rig, rehearsed.player)) {
    return fmt::format("{}: `{}` first", stands, move_to_middle(rehearsed.rig, rehearsed.player, unit));
  }
  return fmt::format(
      "{}: put [start] with displacement_{} = {:.3g} into it; a simulated rig of --local begins each time where {} "
      "says, whatever was moved before",
      stands, unit.of("in"), unit.factor("in") * middle_in, rehearsed.rig.file_name);
}

/// "[start] is 0.2 in from the limit of 5.75 in", that which the rods reach, in the unit of its key; empty without one.
std::string start_beside_limit(const config::ExperimentConfig& experiment, const config::RigLimits& limits,
                               const Rehearsal& rehearsal) {
  const config::Played* played = experiment.played();
  if (played == nullptr || !played->start) return {};
  const double start_in = played->start->displacement_in;
  const bool is_lower = rehearsal.lowest_in - limits.travel_min_in < limits.travel_max_in - rehearsal.highest_in;
  const double limit_in = is_lower ? limits.travel_min_in : limits.travel_max_in;
  const DisplayUnit unit(experiment.positions.contains("start.displacement_mm") ? "mm" : "in");
  const double factor = unit.factor("in");
  return fmt::format("[start] is {:.3g} {} from the limit of {:.4g} {}", factor * std::abs(limit_in - start_in),
                     unit.of("in"), factor * limit_in, unit.of("in"));
}

/// What helps an experiment whose rehearsed rods reach a limit, but nothing that it has already.
std::string remedy_for(const Rehearsed& rehearsed) {
  if (const auto& offset_V = rehearsed.rehearsal->still_offset_V) {  // none with [hold]
    return fmt::format("set offset_V = {:.3f}, which stops the drift, or add [hold]", *offset_V);
  }
  const config::Played* played = rehearsed.experiment.config.played();
  const std::string start = start_beside_limit(rehearsed.experiment.config, rehearsed.rig.limits, *rehearsed.rehearsal);
  const std::string room = start.empty() ? "add [start] where there is room" : "move [start] to where there is room";
  const std::string remedy = played != nullptr && played->hold
                                 ? fmt::format("lower the amplitudes, or {}", room)
                                 : fmt::format("lower the amplitudes, shorten the experiment, {}, or add [hold]", room);
  return start.empty() ? remedy : fmt::format("{}: {}", start, remedy);
}

/// "the valve of [following] (null_V = -0.2, dead_band_V = 0.2)": by what the rehearsed rods move. A measured dead band
/// lies lower, by what the file has to spare.
std::string valve_of(const config::RigConfig& rig) {
  return fmt::format("the valve of [following] (null_V = {:.3g}, dead_band_V = {:.3g})", rig.limits.following->null_V,
                     rig.limits.following->dead_band_V);
}

/// ", 0.05 in from a limit" of rods that come close to one; else empty.
std::string near_limit(const Rehearsal& rehearsal, const config::RigConfig& rig, const DisplayUnit& unit) {
  const double left_in = *margin_of(rehearsal, rig);
  if (left_in >= kCloseShare * (rig.limits.travel_max_in - rig.limits.travel_min_in)) return {};
  return fmt::format(", {:.2g} {} from a limit", unit.factor("in") * std::max(0.0, left_in), unit.of("in"));
}

}  // namespace

bool begins_anew(const config::RigConfig& rig, Player player) {
  return player == Player::local && !hal::moves_machine(rig.backend);
}

namespace {

std::string drift_figure(double drift_per_s) { return fmt::format("{:+.4f}", drift_per_s); }

/// Whether a drift has a figure that is not 0.
bool drifts(double drift_per_s) { return drift_figure(drift_per_s).find_first_of("123456789") != std::string::npos; }

}  // namespace

std::string drift_text(double drift_per_s, const std::string& unit) {
  return drifts(drift_per_s) ? fmt::format("drifts {} {}/s", drift_figure(drift_per_s), unit) : "does not drift";
}

nlohmann::ordered_json to_json(const Rehearsal& rehearsal) {
  return {{"lowest_in", rehearsal.lowest_in},
          {"highest_in", rehearsal.highest_in},
          {"drift_in_per_s", rehearsal.drift_in_per_s},
          {"chance_of_trip", rehearsal.chance_of_trip}};
}

std::optional<double> margin_of(const std::optional<Rehearsal>& rehearsal, const config::RigConfig& rig) {
  if (!rehearsal) return std::nullopt;
  return std::min(rehearsal->lowest_in - rig.limits.travel_min_in, rig.limits.travel_max_in - rehearsal->highest_in);
}

std::string sentence_on(const Rehearsal& rehearsal, const config::RigConfig& rig, const Console& console) {
  const DisplayUnit unit = console.unit(rig.units);
  const double factor = unit.factor("in");
  const bool is_small = std::abs(rehearsal.drift_in_per_s) <= kSmallDrift_in_per_s;
  std::string remedy;
  if (!is_small && rehearsal.still_offset_V) {
    remedy = fmt::format("; offset_V = {:.3f} stops that", *rehearsal.still_offset_V);
  } else if (!is_small && rehearsal.offset_has_no_room) {
    const double left_in = *margin_of(rehearsal, rig);
    const bool is_close = left_in < kCloseShare * (rig.limits.travel_max_in - rig.limits.travel_min_in);
    remedy =
        is_close || rehearsal.chance_of_trip >= kWarnedChanceOfTrip
            ? "; the command limits leave no room for the offset_V that stops that (lower amplitudes do, or [hold])"
            : "; it may be played as it is. The command limits leave no room for the offset_V that stops the drift; "
              "lower amplitudes or [hold] do";
  }
  // The loop stops a rod early enough before a limit that it comes to rest there.
  const bool may_trip = is_at_risk(rehearsal);
  return fmt::format("rehearsed with {}: {} {:.2f} to {:.2f} {} (95 %{}) and {}{}", valve_of(rig),
                     may_trip ? "until it is stopped before a limit the rod moves within" : "the rod stays within",
                     factor * rehearsal.lowest_in, factor * rehearsal.highest_in, unit.of("in"),
                     may_trip ? "" : near_limit(rehearsal, rig, unit),
                     drift_text(factor * rehearsal.drift_in_per_s, unit.of("in")), remedy);
}

bool is_at_risk(const std::optional<Rehearsal>& rehearsal) {
  return rehearsal && rehearsal->chance_of_trip >= kWarnedChanceOfTrip;
}

std::string move_before(const Rehearsed& rehearsed, const Console& console) {
  if (begins_anew(rehearsed.rig, rehearsed.player)) return {};
  if (!is_clear_from_mid_travel(rehearsed.experiment, rehearsed.rig)) return {};
  return move_to_middle(rehearsed.rig, rehearsed.player, console.unit(rehearsed.rig.units));
}

void judge_travel(const Rehearsed& rehearsed, const std::string& experiment_file, TravelRisk risk,
                  const Console& console) {
  const std::optional<Rehearsal>& rehearsal = rehearsed.rehearsal;
  if (!is_at_risk(rehearsal)) return;
  const std::string found = fmt::format("{}: {:.0f} % of the rehearsed rods reach a limit", experiment_file,
                                        100.0 * rehearsal->chance_of_trip);
  const std::string move = move_that_helps(rehearsed, console);
  const std::string remedy =
      fmt::format("{}; measure the valve first if it may not be {} any more (`eha characterise`)",
                  move.empty() ? remedy_for(rehearsed) : move, valve_of(rehearsed.rig));
  if (rehearsal->chance_of_trip >= kRefusedChanceOfTrip && risk == TravelRisk::refuse) {
    throw ConfigError(fmt::format("{}; {:.0f} % or more is refused: {}; --accept-travel-risk plays it nevertheless",
                                  found, 100.0 * kRefusedChanceOfTrip, remedy));
  }
  console.warning(fmt::format("{}; {}", found, remedy));
}

void require_within_travel(const config::ExperimentConfig& experiment, const config::RigConfig& rig, double place_in,
                           const std::string& experiment_file, const Console& console, Player player) {
  if (experiment.placing() != nullptr) return;
  const DisplayUnit unit = console.unit(rig.units);
  const Travel travel{rig.limits.travel_min_in, rig.limits.travel_max_in};
  const std::string beyond = beyond_limit(place_in, travel, unit);
  if (beyond.empty()) return;
  throw ConfigError(fmt::format(
      "{}: the rod stands at {:.3f} {}, {}, from where no experiment is played: {}", experiment_file,
      unit.factor("in") * place_in, unit.of("in"), beyond,
      begins_anew(rig, player)
          ? fmt::format("set where it begins each time, initial_displacement_in (or _mm) of [sim] in {}", rig.file_name)
          : "look at the rod, then " + move_to_middle(rig, player, unit)));
}

void require_place_to_begin(const config::ExperimentConfig& experiment, double place_in,
                            const std::string& experiment_file, const DisplayUnit& unit) {
  const config::Placing* placing = experiment.placing();
  if (placing == nullptr || !placing->from_in) return;
  if (std::abs(place_in - *placing->from_in) <= place::kTolerance_in) return;
  throw ConfigError(fmt::format(
      "{}: it was asked for from {:.3f} {}, and the rod now stands at {:.3f} {}; nothing was moved: ask for "
      "it again from there",
      experiment_file, unit.factor("in") * *placing->from_in, unit.of("in"), unit.factor("in") * place_in,
      unit.of("in")));
}

void warn_if_not_fittable(const config::ExperimentConfig& experiment, const config::RigConfig& rig,
                          const std::string& experiment_file, const Console& console) {
  if (experiment.played() == nullptr) return;
  const double rows = experiment.duration_s * experiment.repetitions / rig.realtime.sample_period_s;
  if (!(rows < kSurelyEnough_rows)) return;
  ident::Record record;
  record.step_s = rig.realtime.sample_period_s;
  record.input = record.output = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(std::lround(rows)));
  try {
    static_cast<void>(ident::fit_rows(record, experiment.fit));
  } catch (const DataError& error) {
    console.warning(
        fmt::format("{}: no model can be fitted to its record: {}; play it longer, or lower "
                    "record.discard_s or record.decimation",
                    experiment_file, error.what()));
  }
}

bool warn_if_not_rehearsed(const config::ExperimentConfig& experiment, const config::RigConfig& rig,
                           const std::string& experiment_file, const Console& console) {
  if (rig.limits.following || experiment.played() == nullptr) return false;
  console.warning(
      fmt::format("{}: not rehearsed, because {} has no [following]; the rod may reach a limit: play `eha "
                  "characterise` first and put its lines into the rig file",
                  experiment_file, rig.file_name));
  return true;
}

void say_motion_shown_first(const config::ExperimentConfig& experiment, const config::RigConfig& rig,
                            const Console& console) {
  if (!(experiment.played() != nullptr || experiment.characterises()) || !config::shows_motion_first(rig)) return;
  const DisplayUnit unit = console.unit(rig.units);
  console.info(fmt::format(
      "nothing shows that the lines of [following] in {} were measured on this rig: first the rod goes {:.2g} {} "
      "towards mid-travel and half-way back, and trips if it does not move as they say; `eha characterise -o` writes "
      "measured ones",
      rig.file_name, unit.factor("in") * config::kShowing_in, unit.of("in")));
}

void warn_of_little_motion(const Rehearsed& rehearsed, const std::string& experiment_file, const Console& console) {
  if (rehearsed.experiment.config.played() == nullptr) return;
  const auto reach_V = reach_within_dead_band(rehearsed.experiment, rehearsed.rig);
  if (!reach_V) return;
  const DisplayUnit unit = console.unit(rehearsed.rig.units);
  const double drift = rehearsed.rehearsal ? unit.factor("in") * rehearsed.rehearsal->drift_in_per_s : 0.0;
  console.warning(fmt::format(
      "{}: the volts go {:.2g} V from the valve's null ({:.3g} V), of which its dead band takes {:.2g} V: the rod {}, "
      "and the record tells little; play greater amplitudes",
      experiment_file, *reach_V, rehearsed.rig.limits.following->null_V,
      config::valve_estimate(*rehearsed.rig.limits.following).dead_band_V,
      drifts(drift) ? drift_text(drift, unit.of("in")) + " to one side and otherwise hardly moves"
                    : "will hardly move"));
}

void report_rehearsal(const Rehearsed& rehearsed, const std::string& experiment_file, TravelRisk risk,
                      const Console& console) {
  if (rehearsed.rehearsal) {
    console.info(fmt::format("{}: {}", experiment_file, sentence_on(*rehearsed.rehearsal, rehearsed.rig, console)));
  }
  warn_of_little_motion(rehearsed, experiment_file, console);
  judge_travel(rehearsed, experiment_file, risk, console);
}

namespace {

std::optional<identify::TripCause> trip_cause_of(const std::string& run_folder, const Console& console) {
  try {
    return identify::trip_cause(record::read_run(run_folder));
  } catch (const Error& error) {
    console.debug(error.what());
    return std::nullopt;
  }
}

std::string sentence_on(const identify::TripCause& cause, const std::string& run_folder, const Console& console) {
  return identify::sentence_of(cause, console.unit(record::rig_units(record::read_manifest(run_folder).other)));
}

}  // namespace

std::string cause_of_trip(const std::string& run_folder, const Console& console) {
  const auto cause = trip_cause_of(run_folder, console);
  return cause ? sentence_on(*cause, run_folder, console) : std::string();
}

bool explain_trip(const std::string& run_folder, const Console& console) {
  const auto cause = trip_cause_of(run_folder, console);
  if (!cause) return false;
  console.info(sentence_on(*cause, run_folder, console));
  return cause->is_other_valve || cause->is_unmeasured;
}

}  // namespace eha::cli
