// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "config/rig_config.hpp"
#include "core/display_unit.hpp"
#include "daemon/acquisition/status_board.hpp"

namespace eha::cli {

/// Displayed progress of a run.
struct RunProgress {
  double played_s = 0.0;  ///< of the experiment
  double total_s = 0.0;
  double elapsed_s = 0.0;  ///< since the first tick, the way to the start and a search of the middle included
  double displacement_in = 0.0;
  double applied_V = 0.0;
  double travel_min_in = 0.0;  ///< limits of the rig
  double travel_max_in = 0.0;
  double travel_percent = 0.0;  ///< share of the way to a travel limit, stopping distance included
  double velocity_percent = 0.0;
  double latency_max_us = 0.0;
  std::uint64_t late = 0;     ///< ticks
  std::uint64_t skipped = 0;  ///< ticks
  double lost_percent = 0.0;  ///< of the experiment's rows so far: those of skipped ticks
  bool is_real_time = true;
  double exploring_at_most_s = 0.0;      ///< of a rod without [following], before the first row; 0: it is not explored
  bool is_placing = false;               ///< ends when the rod is in its place; total_s is then the longest duration
  std::optional<double> margin_in = {};  ///< predicted distance to the nearer travel limit [in]
};

[[nodiscard]] RunProgress progress_of(const acquisition::Snapshot& now, const config::RigConfig& rig);

/// @param status  of ehad-protocol(7), with a run
[[nodiscard]] RunProgress progress_of(const nlohmann::ordered_json& status);

/// "37.7 s left, end 14:32:10  2.953 in, margin 0.80 in  +1.20 V, 0 late  [----#-----]": at most 100 columns. Before
/// the experiment "preparing for 34.0 s, then 1:40 min". Near a limit, and where more rows are lost than a valve sheet
/// may lack, the line starts with a warning.
/// @param now  of the wall clock, local time is shown
[[nodiscard]] std::string run_line(const RunProgress& progress, const DisplayUnit& unit,
                                   std::chrono::system_clock::time_point now);

/// "37.7 s", "5:10 min", "1:02 h".
[[nodiscard]] std::string duration_text(double seconds);

/// Late and skipped ticks, and the greatest latency.
[[nodiscard]] std::string loop_line(const RunProgress& progress);

}  // namespace eha::cli
