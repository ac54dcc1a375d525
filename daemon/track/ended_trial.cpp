// SPDX-License-Identifier: GPL-3.0-or-later
// A trial that ended early.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "config/rig_config.hpp"
#include "config/valve_estimate.hpp"
#include "core/capitalised.hpp"
#include "core/json_text.hpp"
#include "core/os/files.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "daemon/track/track_result.hpp"
#include "ident/valve/supply.hpp"

namespace eha::track {
namespace {

constexpr double kBeforeFault_s = 0.5;
constexpr double kStood_s = 0.3;      // before the end
constexpr double kStood_in = 0.005;   // within it of the reference
constexpr double kFollowed_in = 0.1;  // way that shows that the rod follows

/// The valve that the motion before the fault shows; all 0 where it shows none.
SeenValve seen_until_fault(const TrackResult& played) {
  // The motion due to the fault says nothing about the valve.
  const auto tick_s = played.controller.settings.tick_s;
  const auto left_out = static_cast<std::size_t>(std::lround(kBeforeFault_s / tick_s));
  if (played.rows.rod_in.size() <= left_out) return {};
  const auto until = [&](std::vector<double> values) {
    values.resize(values.size() - left_out);
    return values;
  };
  return seen_valve(until(played.rows.command_V), means(until(played.rows.rod_in), mean_width(tick_s)), tick_s);
}

/// Why a rod stands under volts that should move it. @param known_V  half dead band of [following]
/// @param beyond_V  the volts, from the null of [following]
const char* cause_of_standing(const TrackResult& played, const SeenValve& seen, double beyond_V, double known_V) {
  if (played.leak) return "the volts make up for the leak";
  const bool is_seen = seen.gain_positive_in_per_V_s > 0.0 && seen.gain_negative_in_per_V_s > 0.0;
  const bool is_wider = is_seen && seen.dead_band_V > known_V;
  if (is_wider && beyond_V <= seen.dead_band_V + config::kSameValve_V) {
    return "they are within the dead band that the moving rod shows, which is wider than that of [following]";
  }
  return "oil leaks past the piston and the volts make up for it, or a load or a wrong null does the same, or the dead "
         "band is wider than that of [following]";
}

/// Whether a reading differs from the one before by more than a rod moves in a tick.
bool has_jumps(const TrackResult& played, const config::RigLimits& limits) {
  constexpr double kNoRod = 3.0;    // times the velocity limit
  constexpr double kOfLimit = 0.5;  // of the error that is a fault
  const double least_in = std::max(kNoRod * limits.velocity_limit_in_per_s * played.controller.settings.tick_s,
                                   kOfLimit * played.controller.fault.following_error_in);
  const std::vector<double>& rod = played.rows.rod_in;
  return std::adjacent_find(rod.begin(), rod.end(), [&](double a, double b) { return std::abs(b - a) > least_in; }) !=
         rod.end();
}

/// The valve sheet beside a trial, where it agrees with [following], and what it says of the speed's lag.
std::string slower_valve(const record::OpenRun& opened, const TrackResult& played, const config::RigLimits& limits) {
  constexpr double kSlower = 2.0;
  constexpr double kLeast_s = 0.01;
  constexpr double kSameGain = 1.2;
  const auto run = record::newest_sheet_run(opened.path());
  if (!run || !limits.following) return {};
  const auto sheet = parse_json_text<nlohmann::json>(os::read_file(*run / record::kSheetFile));
  const auto value = [&](const std::string& place) {
    const nlohmann::json::json_pointer pointer(place);
    return sheet.contains(pointer) && sheet.at(pointer).is_number() ? sheet.at(pointer).get<double>()
                                                                    : std::numeric_limits<double>::quiet_NaN();
  };
  const config::ValveEstimate known = config::valve_estimate(*limits.following);
  const auto is_near = [](double a, double b) { return a < kSameGain * b && b < kSameGain * a; };
  const bool agrees = config::is_of_one_valve({known.null_V, known.dead_band_V},
                                              {value("/null_V/value"), std::max(0.0, value("/dead_band_V/value"))}) &&
                      is_near(value("/gain_positive_in_per_V_s/value"), known.gain_positive_in_per_V_s) &&
                      is_near(value("/gain_negative_in_per_V_s/value"), known.gain_negative_in_per_V_s);
  const double lag_s = value("/lag_s");
  const double planned_s = played.controller.settings.feed_forward.acceleration_s;
  if (!agrees || !(lag_s > kSlower * planned_s + kLeast_s)) return {};
  return fmt::format(
      "the valve is slower than the controller's model: by the valve sheet of {} the rod's speed follows the volts "
      "after {:.0f} ms, in the model after {:.0f} ms, while null, dead band and gains are those of [following]. Look "
      "at valve, pilot pressure, filter and oil, and at air in the oil. If it stays so, play the model's experiment "
      "again (`eha run EXPERIMENT`), then `eha tune NEWRUN`",
      run->string(), 1e3 * lag_s, 1e3 * planned_s);
}

constexpr const char* kSensorJumps =
    "the sensor's reading jumps as no rod moves: look at its supply, cable, shield and earth (`eha read` shows its "
    "noise), or put a low-pass filter of some 100 Hz before the card's input";

/// The causes that are none of the sensor; empty where none is seen.
std::string other_cause(const record::OpenRun& opened, const TrackResult& played, const SeenValve& seen,
                        const config::RigLimits& limits) {
  if (std::string slower = slower_valve(opened, played, limits); !slower.empty()) return slower;
  const ident::InverseMap& map = played.controller.settings.inverse;
  const auto factor = ident::common_gain_factor(seen.gain_positive_in_per_V_s / map.gain_positive,
                                                seen.gain_negative_in_per_V_s / map.gain_negative);
  return factor ? fmt::format("both gains are {:.2f} times the controller's: {}", *factor, ident::kSupplyFirst) : "";
}

std::string stood_under_volts(const TrackResult& played, const SeenValve& seen, const config::RigLimits& limits,
                              const DisplayUnit& unit) {
  const TrackRows& rows = played.rows;
  const auto look = static_cast<std::size_t>(std::lround(kStood_s / played.controller.settings.tick_s));
  if (!limits.following || rows.time_s.size() < 2 * look || look == 0) return {};
  const std::size_t from = rows.time_s.size() - look;
  double volts_V = 0.0;
  for (std::size_t i = from; i < rows.time_s.size(); ++i) {
    volts_V += rows.command_V[i] / static_cast<double>(look);
    if (std::abs(rows.reference_in[i] - rows.reference_in.back()) > kStood_in) return {};
    if (std::abs(played.mean_rod_in[i] - rows.reference_in[i]) > kStood_in) return {};
  }
  const double beyond_V = std::abs(volts_V - limits.following->null_V);
  const auto [lowest, highest] = std::minmax_element(played.mean_rod_in.begin(), played.mean_rod_in.end());
  if (*highest - *lowest < kFollowed_in || beyond_V <= limits.following->dead_band_V) return {};
  return fmt::format(
      "until then the rod followed the reference over {:.2g} {}, so that valve, sensor and hydraulics work. At the end "
      "it stood at the reference under {:.2f} V, {:.2f} V from the null, which the checks of [following] (dead_band_V "
      "{:.2f} V) take for a motion that is missing: {}",
      unit.factor("in") * (*highest - *lowest), unit.of("in"), volts_V, beyond_V, limits.following->dead_band_V,
      cause_of_standing(played, seen, beyond_V, limits.following->dead_band_V));
}

}  // namespace

EndedTrial ended_trial(const record::OpenRun& opened, const DisplayUnit& unit) {
  EndedTrial trial{.played = played_track(opened)};
  const record::LoadedRun run = record::read_run(opened);
  if (run.outcome != acquisition::Outcome::faulted) return trial;
  const SeenValve seen = seen_until_fault(trial.played);
  trial.changes = changes_of(seen, trial.played.controller.settings.inverse, unit);
  const config::RigConfig rig = config::parse_rig(run.rig_text, (opened.path() / "run.json (rig)").string());
  trial.is_of_sensor = has_jumps(trial.played, rig.limits);
  trial.cause = trial.is_of_sensor ? kSensorJumps : other_cause(opened, trial.played, seen, rig.limits);
  if (trial.cause.empty()) trial.stood = stood_under_volts(trial.played, seen, rig.limits, unit);
  return trial;
}

std::string advice_of(const EndedTrial& trial, const DisplayUnit& unit) {
  if (trial.played.leak) return ident::leak_finding(*trial.played.leak, unit);
  if (!trial.cause.empty()) return fmt::format("{}.", capitalised(trial.cause));
  if (trial.changes.empty() && trial.stood.empty()) return {};
  return fmt::format("{}.", ident::kMeasureFirst);
}

void write_ended_track(const record::OpenRun& run) {
  const bool is_broken = record::read_manifest(run.files()).outcome == acquisition::Outcome::faulted;
  const EndedTrial trial = ended_trial(run, DisplayUnit("in"));
  nlohmann::ordered_json document{{"schema", "eha-track/1"},
                                  {"run", run.path().string()},
                                  {"kept", is_broken ? nlohmann::ordered_json(false) : nlohmann::ordered_json(nullptr)},
                                  {"ended_early", true},
                                  {"changes", trial.changes}};
  if (const auto& leak = trial.played.leak) {
    document["leak"] = {{"creep_in_per_s", leak->creep_in_per_s}, {"as_V", leak->as_V}};
  }
  if (!trial.stood.empty()) document["stood"] = trial.stood;
  if (!trial.cause.empty()) document["cause"] = trial.cause;
  os::write_file_atomically(run.files() / kTrackFile, document.dump(2) + "\n");
  write_track_rows(trial.played);
}

}  // namespace eha::track
