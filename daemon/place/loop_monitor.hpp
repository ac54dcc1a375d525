// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>

#include "config/rig_config.hpp"
#include "config/valve_estimate.hpp"
#include "daemon/acquisition/earlier_runs.hpp"
#include "daemon/acquisition/limit_monitor.hpp"
#include "daemon/place/speed_slope.hpp"
#include "hal/rig.hpp"

namespace eha::place {

/// Bounds of a closed loop. They hold even if one number of the rig's [following] is wrong.
struct LoopBounds {
  double null_V = 0.0;          ///< middle of the valve's dead band
  double edge_V = 0.0;          ///< |u - null| may take any value up to it at once: half the dead band, and 0.1 V
                                ///< or what moves the rod at 0.1 in/s by [following]
  double most_V = 0.0;          ///< greatest |u - null|
  double growth_V_per_s = 0.0;  ///< fastest growth of |u - null| beyond the edge
  double speed_limit_in_per_s = std::numeric_limits<double>::infinity();  ///< measured, over 50 ms
  double still_V = 0.0;                                                   ///< |u - null| beyond which a rod must move
  double least_gain_in_per_V_s = 0.0;                                     ///< by at least so much for each volt more
  double pressure_delay_s = 0.0;                    ///< in it the command stays at the null, and no motion is due
  std::optional<config::ValveEstimate> valve = {};  ///< the speed is compared with it; none without [following]
  bool compares_slope = false;                      ///< the growth of the speed with the volts, too (SpeedSlope)
};

/// The bounds of a loop that means to move the rod of a rig at most so fast.
///   most    limits.closed_loop_max_V, or 0.3 of half the command range; less if the speed needs less
///   growth  what accelerates a rod whose velocity limit is reached at half the command range by 1.3 in/s^2, at most
///           0.8 V/s: the rod may be faster than the limit and the gains of the file say
///   speed   2.5 times the loop's
/// @param speed_in_per_s  none for a loop about a table of volts, which has speeds of its own
[[nodiscard]] LoopBounds loop_bounds(const config::RigLimits& limits,
                                     double speed_in_per_s = std::numeric_limits<double>::infinity()) noexcept;

/// Keeps a closed loop within its bounds, and says why it must not go on:
///   loop_speed   the slope of the last 50 ms of readings exceeds the speed limit by four of its standard errors
///   no_motion    the rod must move and does not: for the direction d of the command
///                S = max(0, S + g (d (u - null) - still) dt - d dy) exceeds 0.003 in or six standard deviations of the
///                filtered noise; or the command is at its bound for 0.3 s and the reading moves by less
///   wrong_speed  the speed is not within 0.7 to 1.6 times that of [following] for 0.5 s, for a null and a dead band
///                known to 0.03 V: the sensor's slope or the rod's gain has changed, or the sensor lags; or, in a
///                placing, 0.04 in of 0.85 of the way that was due were not measured, in whatever pieces, beside 0.01
///                to 0.03 in/s for the valve's errors: a wire that slips in jerks; or what SpeedSlope finds, where the
///                bounds ask for it
/// y and u pass the same low-pass filter (0.05 s; twice for wrong_speed). Real-time safe; cost: one pass over 50 ms of
/// readings. Not thread-safe.
class LoopMonitor {
 public:
  LoopMonitor(const LoopBounds& bounds, double period_s) noexcept;

  /// The command nearest to the wanted one within the bounds [V]. Once a tick, with the last good reading.
  [[nodiscard]] double bounded_V(double wanted_V, const hal::RigReading& last) noexcept;

  /// Instead of bounded_V() for a loop about a table of volts: checks that the rod moves while the loop's part of the
  /// command is saturated.
  void note(double command_V, bool is_saturated, const hal::RigReading& last) noexcept;

  /// Of the readings so far; stays once there is one.
  [[nodiscard]] const acquisition::Breach& breach() const noexcept { return breach_; }

  [[nodiscard]] const LoopBounds& bounds() const noexcept { return bounds_; }
  /// Whether the pressure has built up, before which nothing counts as missing.
  [[nodiscard]] bool has_pressure() const noexcept { return elapsed_s_ >= bounds_.pressure_delay_s; }

  /// Of the placings before on this rig, from which this one goes on; before the first reading.
  void go_on_from(const acquisition::LackingWay& lacking) noexcept { lacking_ = lacking; }
  [[nodiscard]] const acquisition::LackingWay& lacking() const noexcept { return lacking_; }

 private:
  static constexpr std::size_t kLongestWindow = 512;

  void take(const hal::RigReading& last, bool may_be_still) noexcept;
  void estimate_noise(double place_in) noexcept;
  void check_speed(double place_in) noexcept;
  void check_motion(double moved_in) noexcept;
  void check_saturation() noexcept;
  void compare_speed() noexcept;
  void add_lacking(double due_in_per_s, double speed_in_per_s) noexcept;
  void trip(const acquisition::Breach& breach) noexcept;
  [[nodiscard]] double least_motion_in() const noexcept;

  LoopBounds bounds_;
  double period_s_;
  double weight_;  ///< of the low-pass filters
  std::size_t window_;
  std::array<double, kLongestWindow> places_in_{};
  std::size_t readings_ = 0;
  acquisition::Breach breach_;

  std::array<double, 2> authority_V_;  ///< that |u - null| has grown to, upwards and downwards
  double command_V_;                   ///< held since the reading before
  double filtered_V_;
  double filtered_in_ = 0.0;
  double twice_V_;
  double speed_in_per_s_ = 0.0;  ///< of filtered_in_, filtered once more
  double last_in_ = 0.0;
  double last_change_in_ = 0.0;
  double variance_in2_ = 0.0;  ///< of the readings' noise
  double elapsed_s_ = 0.0;
  std::array<double, 2> missing_in_{};
  std::array<double, 2> due_in_{};
  std::array<double, 2> due_s_{};
  double saturated_s_ = 0.0;
  double saturated_from_in_ = 0.0;
  double slow_s_ = 0.0;
  double fast_s_ = 0.0;
  acquisition::LackingWay lacking_;
  SpeedSlope slope_;
};

}  // namespace eha::place
