// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "config/position.hpp"
#include "hal/backend_list.hpp"

namespace eha::config {

/// Bounds the rig's owner sets; nothing an experiment says widens them.
struct RigLimits {
  double command_min_V = -5.0;  ///< lowest valve command [V]
  double command_max_V = 5.0;   ///< highest valve command [V]
  double slew_V_per_s = 0.0;    ///< fastest change of the command [V/s]
  double safe_V = 0.0;          ///< command that is written whenever the rig is not driven [V]
  double travel_min_in = 0.0;   ///< lowest allowed displacement [in]
  double travel_max_in = 0.0;   ///< highest allowed displacement [in]
  double stopping_deceleration_in_per_s2 =
      0.0;                               ///< deceleration that the rig reaches on a stop, for the stopping distance
  double velocity_limit_in_per_s = 0.0;  ///< highest allowed speed [in/s]
  double frozen_sensor_s = 0.0;          ///< an unchanged code for this long while driven trips [s]; 0 is off
};

/// How ticks are kept.
struct RealtimeOptions {
  double sample_period_s = 0.001;  ///< tick period [s]
  int priority = 80;               ///< SCHED_FIFO priority, 1..99
  std::optional<int> cpu;          ///< CPU the loop is bound to
  int abort_consecutive_late = 5;  ///< consecutive late or skipped ticks that end a run
  int abort_total_late = 50;       ///< leaky total of late or skipped ticks that ends a run
};

/// A whole rig.toml.
struct RigConfig {
  std::string name;
  hal::Backend backend;  ///< what drives the rig, with its options; hal/backend.hpp answers questions about it
  RigLimits limits;
  RealtimeOptions realtime;
  std::string file_name;  ///< as given, for messages
  std::string text;       ///< the file's content as read, for the run's manifest
  PositionMap positions;  ///< where each key stands in the file
};

/// Reads a rig file.
/// @throws ConfigError      missing, unreadable, not TOML, or wrong: every error at once, in file order
/// @throws PermissionError  the caller may not read it
[[nodiscard]] RigConfig load_rig(const std::string& path);

/// The same for text already in memory; file_name is used in messages only.
/// @throws ConfigError as load_rig
[[nodiscard]] RigConfig parse_rig(std::string_view text, const std::string& file_name);

}  // namespace eha::config
