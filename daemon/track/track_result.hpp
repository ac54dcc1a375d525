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
#include "ident/control/trial.hpp"

namespace eha::track {

inline constexpr const char* kTrackFile = "track.json";
inline constexpr const char* kTrackRows = "track.csv";

/// Which way a promised figure is broken.
enum class Bound {
  most,   ///< by more than the promise's upper value
  least,  ///< by less than its lower one: a margin
};

/// A figure that was promised, and what the rig did.
struct KeptFigure {
  std::string name;
  std::string unit;
  double measured = 0.0;
  double noise = 0.0;  ///< what the sensor's noise, and the means over 50 ms, can have added to it
  config::PromisedFigure promised;
  Bound bound = Bound::most;
  [[nodiscard]] double limit() const noexcept { return bound == Bound::most ? promised.upper : promised.lower; }
  /// Whether the noise leaves it to be seen that the promise is kept or not.
  [[nodiscard]] bool is_decided() const noexcept { return beyond() <= 0.0 || beyond() > noise; }
  [[nodiscard]] bool is_kept() const noexcept { return beyond() <= noise; }
  /// By how much it is worse than the limit.
  [[nodiscard]] double beyond() const noexcept {
    return bound == Bound::most ? measured - limit() : limit() - measured;
  }
};

/// Rows of the trial, a row a tick from the controller's first.
struct TrackRows {
  std::vector<double> time_s;
  std::vector<double> reference_in;
  std::vector<double> rod_in;  ///< as read
  std::vector<double> command_V;
};

/// The valve as the moving rod shows it, by least squares over the rows in which it moves:
///   u = null + d dead_band + v / gain(d) + T v'   d the direction of the speed v
struct SeenValve {
  double null_V = 0.0;
  double dead_band_V = 0.0;
  double gain_positive_in_per_V_s = 0.0;
  double gain_negative_in_per_V_s = 0.0;
};

/// What a run of [track] shows.
struct TrackResult {
  std::filesystem::path folder;
  std::string units;  ///< of the rig file, for people; empty: inches
  config::ControllerConfig controller;
  std::vector<KeptFigure> figures;
  double noise_in = 0.0;  ///< standard deviation of a reading
  TrackRows rows;
  std::vector<double> mean_reference_in;  ///< over 50 ms about each row
  std::vector<double> mean_rod_in;        ///< the same
  double reference_behind_in = 0.0;       ///< greatest distance of the generated reference from set points of one's own
  SeenValve valve;
  std::optional<std::pair<double, double>> sweep_s = {};  ///< of the rows: from, to; none without a sweep
  bool margins_retracting = false;                        ///< direction of `margins`
  std::optional<ident::MeasuredMargins> margins = {};     ///< none: the trial has no sweep, or the loop was not steady
  bool shows_valve = true;                                ///< the trial has the speeds that tell it
  [[nodiscard]] bool is_kept() const noexcept;            ///< no figure is broken
};

/// Computes the figures of a completed run of [track]. Errors are means over 50 ms, because a reading's noise is no
/// error of the rod. The reference is generated again from the readings.
/// @throws DataError  the run is none of [track], or is not complete
/// @throws IoError, PermissionError  as record::read_run
[[nodiscard]] TrackResult track_result(const std::filesystem::path& folder);

/// The rows of a run of [track] and their means, also of one that ended early; without figures.
/// @throws DataError  the run is none of [track], or has no row of the controller
/// @throws IoError, PermissionError  as record::read_run
[[nodiscard]] TrackResult played_track(const std::filesystem::path& folder);

/// What the moving rod shows of the valve against the controller's, a phrase each.
[[nodiscard]] std::vector<std::string> changes_of(const TrackResult& result, const DisplayUnit& unit);

/// The same of a trial that ended early; nothing where the rod moved too little.
/// @throws DataError, IoError, PermissionError  as track_result()
[[nodiscard]] std::vector<std::string> changes_until_fault(const std::filesystem::path& folder,
                                                           const DisplayUnit& unit);

/// "yes", "no" or "hidden by noise".
[[nodiscard]] std::string kept_text(const KeptFigure& figure);
/// "5 of 7 figures are kept, 2 are hidden by the sensor's noise".
[[nodiscard]] std::string kept_text(const TrackResult& result);

/// Measured beside promised, for people.
[[nodiscard]] std::string track_text(const TrackResult& result, const DisplayUnit& unit);
[[nodiscard]] nlohmann::ordered_json to_json(const TrackResult& result);

/// Writes track.json and track.csv into the run's folder. @throws IoError, PermissionError
void write_track(const TrackResult& result);

/// Writes track.json of a trial that ended early: not kept, and changes_until_fault(); and track.csv of what was
/// played.
/// @throws as changes_until_fault() and played_track()
void write_ended_track(const std::filesystem::path& folder);

}  // namespace eha::track
