// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/controller_config.hpp"
#include "core/display_unit.hpp"
#include "daemon/record/open_run.hpp"
#include "daemon/track/seen_valve.hpp"
#include "ident/control/trial.hpp"
#include "ident/valve/leak.hpp"

namespace eha::track {

inline constexpr const char* kTrackFile = "track.json";
inline constexpr const char* kTrackRows = "track.csv";

/// Direction in which a promised figure is broken.
enum class Bound {
  most,   ///< by exceeding the promise's upper value
  least,  ///< by falling below its lower value: a margin
};

/// A promised figure and its measured value.
struct KeptFigure {
  std::string name;
  std::string unit;
  double measured = 0.0;
  double noise = 0.0;  ///< greatest contribution of the sensor's noise and of the means over 50 ms
  config::PromisedFigure promised;
  Bound bound = Bound::most;
  bool is_two_sided = false;    ///< the noise may as well have made it better
  bool is_lower_bound = false;  ///< the measured value is at least this
  [[nodiscard]] double limit() const noexcept { return bound == Bound::most ? promised.upper : promised.lower; }
  /// Whether the noise is small enough to decide if the promise is kept.
  [[nodiscard]] bool is_decided() const noexcept {
    return beyond() > noise || beyond() <= (is_two_sided ? -noise : 0.0);
  }
  [[nodiscard]] bool is_kept() const noexcept { return beyond() <= noise; }
  /// Returns the amount by which it is worse than the limit.
  [[nodiscard]] double beyond() const noexcept {
    return bound == Bound::most ? measured - limit() : limit() - measured;
  }
};

/// Rows of the trial, a row a tick from the controller's first, in times of the run's record.
struct TrackRows {
  std::vector<double> time_s;
  std::vector<double> reference_in;
  std::vector<double> rod_in;  ///< as read
  std::vector<double> command_V;
};

/// Results of a run of [track].
struct TrackResult {
  std::filesystem::path folder;
  record::OpenRun opened;  ///< the same, held
  std::string units;       ///< of displayed lengths, from the rig file; empty: inches
  config::ControllerConfig controller;
  std::optional<ident::Leak> leak = {};  ///< of the rig, by the newest valve sheet beside the run, or the controller's
  std::vector<KeptFigure> figures;
  double noise_in = 0.0;  ///< standard deviation of a reading
  TrackRows rows;
  std::optional<double> trip_s = {};      ///< when a fault ended the trial, in times of the rows
  std::vector<double> mean_reference_in;  ///< over kMean_s about each row, over less at the ends
  std::vector<double> mean_rod_in;        ///< the same
  double reference_behind_in = 0.0;       ///< greatest distance of the generated reference from the user's set points
  SeenValve valve;
  std::optional<std::pair<double, double>> sweep_s = {};  ///< of the rows: from, to; none without a sweep
  bool margins_retracting = false;                        ///< direction of `margins`
  std::optional<ident::MeasuredMargins> margins = {};     ///< none: the trial has no sweep, or the loop was not steady
  bool shows_valve = true;                                ///< the trial has the speeds that determine it
  [[nodiscard]] bool is_kept() const noexcept;            ///< no figure is broken
};

/// Computes the figures of a completed run of [track]. Errors are means over 50 ms, which reduces the readings' noise.
/// Generates the reference again from the readings.
/// @throws DataError  the run is none of [track], or is not complete
/// @throws IoError, PermissionError  as record::read_run
[[nodiscard]] TrackResult track_result(const record::OpenRun& run);

/// The rows of a run of [track] and their means, also of one that ended early; without figures.
/// @throws DataError  the run is none of [track], or has no row of the controller
/// @throws IoError, PermissionError  as record::read_run
[[nodiscard]] TrackResult played_track(const record::OpenRun& run);

/// Compares the valve that the rod's motion shows with the controller's, a phrase each.
[[nodiscard]] std::vector<std::string> changes_of(const TrackResult& result, const DisplayUnit& unit);

/// What follows from the figures and the changes, in sentences: whether the promise is kept, the leak of a rig whose
/// sheet shows one, else what to measure. Commands are named in short.
[[nodiscard]] std::string advice_of(const TrackResult& result, const DisplayUnit& unit);

/// Whether the controller may go to a PLC after this trial: the rig does not leak, and nothing comes first.
[[nodiscard]] bool goes_to_plc(const TrackResult& result, const DisplayUnit& unit);

/// "yes", "no" or "hidden by noise".
[[nodiscard]] std::string kept_text(const KeptFigure& figure);
/// "5 of 7 figures are kept, 2 are hidden by the sensor's noise".
[[nodiscard]] std::string kept_text(const TrackResult& result);

/// Gain and lag by the sweep, and what the margins are, in sentences; that they are not measured without one.
[[nodiscard]] std::vector<std::string> sweep_sentences(const TrackResult& result, const DisplayUnit& unit);

/// Writes the measured and the promised figures, for display.
[[nodiscard]] std::string track_text(const TrackResult& result, const DisplayUnit& unit);
[[nodiscard]] nlohmann::ordered_json to_json(const TrackResult& result);

/// Writes track.json and track.csv into the run's folder. @throws IoError, PermissionError
void write_track(const TrackResult& result);
/// Writes track.csv alone.
void write_track_rows(const TrackResult& result);

/// What a trial that a fault ended showed of its cause.
struct EndedTrial {
  TrackResult played;
  std::vector<std::string> changes = {};  ///< of the valve until half a second before the fault
  /// Of a missing motion: the rod stood at a resting reference under volts beyond the dead band of [following], after
  /// it had followed, so that valve, sensor and hydraulics are sound; empty otherwise.
  std::string stood = {};
  /// What the record and the newest valve sheet beside it show of another cause, with what to do: readings that jump, a
  /// valve that agrees with [following] and is slower than the controller's plant, or both gains changed alike; empty
  /// otherwise.
  std::string cause = {};
  bool is_of_sensor = false;  ///< `cause` is readings that jump
  [[nodiscard]] bool is_cause_known() const {
    return !cause.empty() || !stood.empty() || (played.leak && !changes.empty());
  }
};

/// @throws DataError, IoError, PermissionError  as played_track()
[[nodiscard]] EndedTrial ended_trial(const record::OpenRun& run, const DisplayUnit& unit);

/// The same as for a completed trial.
[[nodiscard]] std::string advice_of(const EndedTrial& trial, const DisplayUnit& unit);

/// Writes track.json of a trial that ended early: not kept, and what it showed; and track.csv of what was played. A
/// trial that was stopped is judged by nobody. @throws as ended_trial()
void write_ended_track(const record::OpenRun& run);

}  // namespace eha::track
