// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/trip_cause.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "config/prepared_experiment.hpp"
#include "config/rig_config.hpp"
#include "config/stopping_distance.hpp"
#include "core/error.hpp"
#include "daemon/rehearsal/rehearsal.hpp"
#include "ident/statistics/robust.hpp"

namespace eha::identify {
namespace {

constexpr double kLast_s = 0.1;      // of the record, over which the rod's own speed shows
constexpr double kDriftShare = 0.5;  // of the way to the limit that the drift makes
constexpr double kSlowShare = 0.5;   // of the velocity limit: a rod this slow did not exceed it
constexpr double kSurelyWithin_in = 0.05;
constexpr double kSameOffset_V = 0.02;
constexpr Eigen::Index kFewestForTrip = 10;

/// A straight line through the last rows but the last one, which may be the one that is wrong.
struct LastMotion {
  double end_in = 0.0;
  double speed_in_per_s = 0.0;
};

LastMotion last_motion(const ident::Record& record) {
  const auto wanted = static_cast<Eigen::Index>(std::lround(kLast_s / record.step_s));
  const Eigen::Index rows = std::clamp<Eigen::Index>(wanted, kFewestForTrip, record.output.size() - 1);
  const Eigen::VectorXd y = record.output.segment(record.output.size() - 1 - rows, rows);
  const Eigen::VectorXd t = record.step_s * Eigen::VectorXd::LinSpaced(rows, -0.5 * static_cast<double>(rows - 1),
                                                                       0.5 * static_cast<double>(rows - 1));
  const double speed = t.dot(y) / t.squaredNorm();
  return {y.mean() + speed * t[rows - 1], speed};
}

/// Whether the rod itself was within the limit that ended the run.
bool is_within(const LastMotion& motion, std::string_view fault, const config::RigConfig& rig) {
  const config::RigLimits& limits = rig.limits;
  const double speed = std::abs(motion.speed_in_per_s);
  if (fault == acquisition::to_text(acquisition::Fault::velocity_limit)) {
    return speed < kSlowShare * limits.velocity_limit_in_per_s;
  }
  const double stopping_in = config::stopping_distance_in(limits, rig.realtime.sample_period_s, speed);
  const bool is_up = motion.speed_in_per_s > 0.0;
  return motion.end_in + (is_up ? stopping_in : 0.0) < limits.travel_max_in - kSurelyWithin_in &&
         motion.end_in - (is_up ? 0.0 : stopping_in) > limits.travel_min_in + kSurelyWithin_in;
}

}  // namespace

std::optional<TripCause> trip_cause(const record::LoadedRun& run) {
  using acquisition::Fault;
  if (run.outcome != acquisition::Outcome::faulted || !run.manifest.report) return std::nullopt;
  const Eigen::VectorXd& y = run.record.output;
  const std::string& description = run.manifest.report->description;
  const std::string fault = description.substr(0, description.find(' '));
  const bool is_travel = fault == acquisition::to_text(Fault::travel_limit);
  if (!is_travel && fault != acquisition::to_text(Fault::velocity_limit)) return std::nullopt;
  if (y.size() <= kFewestForTrip || !y.allFinite()) return std::nullopt;
  try {
    const config::RigConfig rig = config::parse_rig(run.rig_text, (run.folder / "run.json (rig)").string());
    const LastMotion motion = last_motion(run.record);
    if (is_within(motion, fault, rig)) {
      return TripCause{
          .is_of_sensor = true, .speed_in_per_s = motion.speed_in_per_s, .noise_in = ident::scatter_of_rows(y)};
    }
    if (!is_travel) return std::nullopt;
    if (!rig.limits.following) {
      return record::purpose_of(run.manifest) == record::Purpose::models
                 ? std::optional(TripCause{.is_unmeasured = true})
                 : std::nullopt;
    }
    const config::PreparedExperiment experiment =
        config::parse_prepared_experiment(run.experiment_text, (run.folder / "run.json (experiment)").string(), rig);
    const std::optional<Drift> drift = drift_of(experiment, rig, y);
    const double way_in = std::abs(y[y.size() - 1] - y[0]);
    if (!drift ||
        !(std::abs(drift->rate_in_per_s) * static_cast<double>(y.size()) * run.record.step_s > kDriftShare * way_in)) {
      return std::nullopt;
    }
    const std::optional<Rehearsal> rehearsal = rehearse(experiment, rig, y[0]);
    TripCause cause{.speed_in_per_s = drift->rate_in_per_s,
                    .offset_V = drift->offset_V,
                    .rehearsed_V = rehearsal ? rehearsal->still_offset_V : std::nullopt,
                    .is_other_valve = rehearsal && rehearsal->chance_of_trip < kWarnedChanceOfTrip};
    cause.is_clear_from_middle = !cause.is_other_valve && is_clear_from_mid_travel(experiment, rig);
    // One number for one drift.
    if (cause.offset_V && cause.rehearsed_V && std::abs(*cause.rehearsed_V - *cause.offset_V) <= kSameOffset_V) {
      cause.offset_V = cause.rehearsed_V;
    }
    return cause;
  } catch (const Error&) {  // of a version whose files are no longer read
    return std::nullopt;
  }
}

std::string sentence_of(const TripCause& cause, const DisplayUnit& unit) {
  const double factor = unit.factor("in");
  const std::string in = unit.of("in");
  if (cause.is_of_sensor) {
    return fmt::format(
        "the rod itself was within the limit: over the last 0.1 s it moved at {:.2g} {}/s, and the sensor's readings "
        "scatter by {:.2g} {} (rms). Less volts do not help: {}",
        factor * std::abs(cause.speed_in_per_s), in, factor * cause.noise_in, in, remedy_of(cause));
  }
  if (cause.is_unmeasured) {
    return "the rig file has no [following], so that nothing showed beforehand where the rod goes: " + remedy_of(cause);
  }
  std::string text = fmt::format("the rod drifted at {:+.4f} {}/s into the limit", factor * cause.speed_in_per_s, in);
  if (cause.is_other_valve) {
    const std::string stops = cause.offset_V ? fmt::format(" (offset_V = {:.3f} stops it)", *cause.offset_V) : "";
    return fmt::format(
        "{}, where rods with the valve of [following] stay clear of it{}: likely the valve is another one now, the rig "
        "leaks, its supply or load has changed, or the sensor drifts: {}",
        text, stops, remedy_of(cause));
  }
  if (cause.is_clear_from_middle) {
    return fmt::format("{}; rods that begin at mid-travel stay clear of it: {}", text, remedy_of(cause));
  }
  if (!cause.offset_V) return text + ", and no offset_V within the command limits stops that: " + remedy_of(cause);
  text += fmt::format("; offset_V = {:.3f} stops that", *cause.offset_V);
  if (cause.rehearsed_V && *cause.rehearsed_V != *cause.offset_V) {
    text += fmt::format(
        " by this record ({:.3f}, which the rehearsal names, is for the valve of [following]: this rod moves "
        "otherwise)",
        *cause.rehearsed_V);
  }
  return text;
}

std::string remedy_of(const TripCause& cause) {
  if (cause.is_of_sensor) {
    return "look at the sensor's supply, cable, shield and earth (`eha read` shows its noise), or put a low-pass "
           "filter of some 100 Hz before the card's input";
  }
  if (cause.is_unmeasured) {
    return "first `eha characterise`; with the rig file that it writes `eha check` names the way of the rod, and the "
           "offset_V that stops a drift";
  }
  if (cause.is_other_valve) return "`eha characterise` measures the valve of today, and shows a leak";
  if (cause.is_clear_from_middle) {
    return "begin at mid-travel, from where the rehearsed rods stay clear of the limits: [start] in the "
           "experiment file, or, through the service, `eha goto` before the run";
  }
  if (cause.offset_V) {
    return fmt::format("set offset_V = {:.3f} in [excitation] of the experiment file, or add [hold]", *cause.offset_V);
  }
  return "lower the amplitudes, or add [hold]";
}

}  // namespace eha::identify
