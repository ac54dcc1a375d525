// SPDX-License-Identifier: GPL-3.0-or-later
// A trial that ended early.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "config/rig_config.hpp"
#include "config/valve_estimate.hpp"
#include "core/os/files.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/track/track_result.hpp"

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
const char* cause_of_standing(const TrackResult& played, const SeenValve& seen, double volts_V, double known_V) {
  if (played.leak) return "the volts make up for the leak";
  const bool is_seen = seen.gain_positive_in_per_V_s > 0.0 && seen.gain_negative_in_per_V_s > 0.0;
  const bool is_wider = is_seen && seen.dead_band_V > known_V;
  if (is_wider && std::abs(volts_V - seen.null_V) <= seen.dead_band_V + config::kSameValve_V) {
    return "they are within the dead band that the moving rod shows, which is wider than that of [following]";
  }
  return "oil leaks past the piston and the volts make up for it, or a load or a wrong null does the same";
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
      cause_of_standing(played, seen, volts_V, limits.following->dead_band_V));
}

}  // namespace

EndedTrial ended_trial(const record::OpenRun& opened, const DisplayUnit& unit) {
  EndedTrial trial{.played = played_track(opened)};
  const record::LoadedRun run = record::read_run(opened);
  if (run.outcome != acquisition::Outcome::faulted) return trial;
  const SeenValve seen = seen_until_fault(trial.played);
  trial.changes = changes_of(seen, trial.played.controller.settings.inverse, unit);
  const config::RigConfig rig = config::parse_rig(run.rig_text, (opened.path() / "run.json (rig)").string());
  trial.stood = stood_under_volts(trial.played, seen, rig.limits, unit);
  return trial;
}

std::string advice_of(const EndedTrial& trial, const DisplayUnit& unit) {
  if (trial.played.leak) return ident::leak_finding(*trial.played.leak, unit);
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
  os::write_file_atomically(run.files() / kTrackFile, document.dump(2) + "\n");
  write_track_rows(trial.played);
}

}  // namespace eha::track
