// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "config/position.hpp"
#include "core/display_unit.hpp"
#include "core/keys.hpp"
#include "hal/backends/backend_list.hpp"

namespace eha::config {

/// Commissioned response of the rod to the valve. The following check compares the sensor with it. At a command u
/// outside the dead band the rod moves at least at the speed gain (u - null -+ dead band).
struct Following {
  double gain_positive_in_per_V_s = 0.0;  ///< half the measured gain towards greater displacement [in/(V s)]
  double gain_negative_in_per_V_s = 0.0;  ///< the same towards smaller displacement, positive [in/(V s)]
  double null_V = 0.0;                    ///< command at the middle of the dead band [V]
  double dead_band_V = 0.0;               ///< half width, variation included [V]
  double limit_in = 0.1;                  ///< missing or excess motion at which the rig is made safe [in]
  double pressure_delay_s = 0.0;  ///< time from enable to full pressure; motion missing in it does not count [s]

  // Half widths of the 95 % intervals, from the valve sheet; none: defaults of valve_uncertainty().
  std::optional<double> null_uncertainty_V = {};        ///< [V]
  std::optional<double> dead_band_uncertainty_V = {};   ///< [V]
  std::optional<double> gain_uncertainty_percent = {};  ///< of each gain [%]
  /// Sum over the measured numbers, as `eha characterise` wrote them; see config/measured_check.hpp
  std::optional<std::uint32_t> measured_check = {};
  std::optional<std::uint32_t> measured_rig_check = {};  ///< the same over card, channels and calibration

  static void visit_keys(auto& self, auto& keys) {
    keys.number("gain_positive_in_per_V_s", self.gain_positive_in_per_V_s, Range::above(0.0));
    keys.number("gain_negative_in_per_V_s", self.gain_negative_in_per_V_s, Range::above(0.0));
    keys.number("null_V", self.null_V, Range::between(-10.0, 10.0));
    keys.number("dead_band_V", self.dead_band_V, Range::at_least(0.0));
    keys.number("limit_in", self.limit_in, Range::above(0.0), Need::optional);
    keys.number("pressure_delay_s", self.pressure_delay_s, Range::between(0.0, 10.0), Need::optional);
    keys.number("null_uncertainty_V", self.null_uncertainty_V, Range::between(0.0, 10.0));
    keys.number("dead_band_uncertainty_V", self.dead_band_uncertainty_V, Range::between(0.0, 10.0));
    keys.number("gain_uncertainty_percent", self.gain_uncertainty_percent, Range::between(0.0, 100.0));
    keys.integer("measured_check", self.measured_check, 0, std::numeric_limits<std::uint32_t>::max());
    keys.integer("measured_rig_check", self.measured_rig_check, 0, std::numeric_limits<std::uint32_t>::max());
  }
};

/// Valid voltages of the displacement sensor's wire.
struct SensorBand {
  double valid_min_V = 0.0;                   ///< lowest voltage of a sound sensor [V]
  double valid_max_V = 0.0;                   ///< highest voltage of a sound sensor [V]
  std::optional<double> open_circuit_V = {};  ///< reading of the input with the wire disconnected [V]; none: unknown

  static void visit_keys(auto& self, auto& keys) {
    keys.number("valid_min_V", self.valid_min_V, Range::any());
    keys.number("valid_max_V", self.valid_max_V, Range::any());
    keys.number_or_unknown("open_circuit_V", self.open_circuit_V);
  }
};

/// Bounds set by the rig's owner; no experiment can widen them.
struct RigLimits {
  double command_min_V = -5.0;  ///< lowest valve command [V]
  double command_max_V = 5.0;   ///< highest valve command [V]
  double slew_V_per_s = 0.0;    ///< fastest change of the command [V/s]
  double safe_V = 0.0;          ///< command written whenever the rig is not driven [V]
  double travel_min_in = 0.0;   ///< lowest allowed displacement [in]
  double travel_max_in = 0.0;   ///< highest allowed displacement [in]
  double stopping_deceleration_in_per_s2 =
      0.0;                               ///< deceleration that the rig reaches on a stop, for the stopping distance
  double velocity_limit_in_per_s = 0.0;  ///< highest allowed speed [in/s]
  double frozen_sensor_s = 0.0;          ///< while driven, a code unchanged for this long trips [s]; 0 is off
  /// Greatest distance of a closed loop's command from the valve's null [V]; none: 0.3 of half the command range
  std::optional<double> closed_loop_max_V = {};
  std::optional<Following> following = {};  ///< [following]; none: the following check has no data of the valve
  std::optional<SensorBand> sensor = {};    ///< [sensor]; none: every voltage of the converter is valid

  /// Middle between the travel limits [in].
  [[nodiscard]] double mid_travel_in() const noexcept { return 0.5 * (travel_min_in + travel_max_in); }

  /// [limits]
  static void visit_keys(auto& self, auto& keys) {
    keys.number("command_min_V", self.command_min_V, Range::between(-10.0, 10.0));
    keys.number("command_max_V", self.command_max_V, Range::between(-10.0, 10.0));
    keys.number("slew_V_per_s", self.slew_V_per_s, Range::above(0.0));
    keys.number("safe_V", self.safe_V, Range::between(-10.0, 10.0));
    keys.number("travel_min_in", self.travel_min_in, Range::any());
    keys.number("travel_max_in", self.travel_max_in, Range::any());
    keys.number("stopping_deceleration_in_per_s2", self.stopping_deceleration_in_per_s2, Range::above(0.0));
    keys.number("velocity_limit_in_per_s", self.velocity_limit_in_per_s, Range::above(0.0));
    keys.number("frozen_sensor_s", self.frozen_sensor_s, Range::at_least(0.0));
    keys.number("closed_loop_max_V", self.closed_loop_max_V, Range{.low = 0.0, .high = 10.0, .low_excluded = true});
  }
};

/// Period, scheduling and lateness limits of the tick loop.
struct RealtimeOptions {
  double sample_period_s = 0.001;  ///< tick period [s]
  int priority = 80;               ///< SCHED_FIFO priority, 1..99; the loop takes kHighestLoopPriority at most
  std::optional<int> cpu;          ///< CPU the loop is bound to
  int abort_consecutive_late = 5;  ///< consecutive late or skipped ticks that end a run
  int abort_total_late = 50;       ///< leaky total of late or skipped ticks that ends a run
  /// Time without a beat, beyond one period, after which the guard switches the hydraulics off [s]; none: depends on
  /// the kernel, see acquisition::stall_limit_ns
  std::optional<double> stall_limit_s = {};

  static void visit_keys(auto& self, auto& keys) {
    keys.number("sample_period_s", self.sample_period_s, Range::between(1e-4, 1.0), Need::optional);
    keys.integer("priority", self.priority, 1, 99, Need::optional);
    keys.integer("cpu", self.cpu, 0, 1023);
    keys.integer("abort_consecutive_late", self.abort_consecutive_late, 1, 1'000'000, Need::optional);
    keys.integer("abort_total_late", self.abort_total_late, 1, 1'000'000, Need::optional);
    keys.number("stall_limit_s", self.stall_limit_s, Range::between(0.01, 1.0));
  }
};

/// A whole rig.toml.
struct RigConfig {
  std::string name;
  std::string units = {};  ///< one of kLengthUnits, for displayed values of this rig; empty: in
  bool is_sample = false;  ///< a shipped example: never drives a machine
  hal::Backend backend;    ///< backend of the rig with its options; hal/backends/backend.hpp answers questions about it
  RigLimits limits;
  RealtimeOptions realtime;
  std::string file_name;  ///< as given, for messages
  std::string text;       ///< the file's content as read, for the run's manifest
  PositionMap positions;  ///< position of each key in the file

  /// The keys that run.json records, too: all but the backend, whose table has its name, and `sample`.
  static void visit_keys(auto& self, auto& keys) {
    keys.text("name", self.name);
    keys.table("limits", self.limits);
    keys.table("realtime", self.realtime, Need::optional);
    keys.choice("units", self.units, unit_names(), Need::optional);
    keys.optional_table("following", self.limits.following);
    keys.optional_table("sensor", self.limits.sensor);
  }

 private:
  /// kLengthUnits as choices.
  [[nodiscard]] static std::vector<std::pair<std::string_view, std::string>> unit_names() {
    std::vector<std::pair<std::string_view, std::string>> names;
    for (const LengthUnit& unit : kLengthUnits) names.emplace_back(unit.name, unit.name);
    return names;
  }
};

/// Reads a rig file.
/// @throws ConfigError      missing, unreadable, not TOML, or wrong: every error at once, in file order
/// @throws PermissionError  the caller may not read it
[[nodiscard]] RigConfig load_rig(const std::string& path);

/// Reads a rig from text in memory; file_name is used in messages only.
/// @throws ConfigError as load_rig
[[nodiscard]] RigConfig parse_rig(std::string_view text, const std::string& file_name);

}  // namespace eha::config
