// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "config/rig_config.hpp"

namespace eha::place {

/// Finds out whether the sensor shows the rod of an unknown valve move, by pulses of the command about the safe
/// voltage, or another at which the rod rests or drifts slowly. Each is a triangle of 4 half ranges a second, at most
/// 20 V/s, greater by half than the one before, up to what an Explorer may command, at most 1.5 V; the last is held for
/// 0.06 s. Where the slew limit is lower, a pulse has a lower peak and the same volt-seconds. No pulse has more than
/// 0.2025 V s, at any range, slew limit and tick; under 5 V/s the last one has what reaches 1 V, at most 0.3 V s. After
/// each comes one the other way of half its area, at most 0.101 V s, or of what lets a pulse that was seen be repeated;
/// the sum of all is at most 0.36 V s before the rod is seen twice: an unseen rod of 2 in/(V s) is moved by some 0.7
/// in, and its mean motion is in the asked direction. Two pulses the other way in a row that move the rod, or one after
/// a pulse that was seen, show that the sensor is alive and the valve's null not in the middle: then the pulses go on
/// to 0.5 V s. Compared are the means of the readings before and after a pulse, less the drift, each over 0.2 s or as
/// long as the pulse. A pulse ends when it moves the rod by 0.006 in. Motion counts where it is at least 0.002 in, six
/// of its standard deviations and what the change of the drift over the pulse explains. One change of a reading shows
/// nothing: the same pulse must be seen again after one the other way, by half as much at least. Then lesser ones are
/// tried until one is not seen, as the pressure may have come late, up to three more halve the way between, and the
/// least one must be seen once more. While the reading changes by more than 0.03 in/s the means are taken again until
/// it rests or three changes agree.
///   seen       motion in the asked direction, twice
///   drifts     the same of a rod that moves steadily without a pulse, too
///   unseen     no pulse did that: the sensor is dead, the valve closed or without pressure
///   backwards  a pulse moved the rod the other way
///   unsteady   the reading neither rests nor drifts steadily for 5 s in all
/// Real-time safe; cost: some thirty operations a tick. Not thread-safe.
class Probe {
 public:
  enum class Result { none, seen, drifts, unseen, backwards, unsteady };

  /// @param most_V  greatest command from the safe voltage
  Probe(const config::RigLimits& limits, double most_V, double period_s) noexcept;

  /// @param direction  1 or -1
  void begin(double direction) noexcept;

  /// The command of one tick from the safe voltage [V]. @param place_in  the last good reading
  [[nodiscard]] double offset_V(double place_in) noexcept;

  /// None while the pulses go on.
  [[nodiscard]] Result result() const noexcept { return result_; }
  /// Peak of the least pulse that was seen [V].
  [[nodiscard]] double seen_V() const noexcept { return seen_V_; }
  /// What the last pulse moved the rod by in its direction, or the reading changed by from one mean to the next where
  /// it is unsteady, and what would have been motion [in].
  [[nodiscard]] double moved_in() const noexcept { return moved_in_; }
  [[nodiscard]] double least_in() const noexcept;

 private:
  static constexpr double kSettling_s = 0.1;
  enum class Phase { coming_to_rest, before, pulse, settling, after, later };

  void begin_pulse() noexcept;
  void shape_pulse() noexcept;
  void grow() noexcept;
  void enter(Phase phase) noexcept;
  void compare(double mean_in) noexcept;
  void drive() noexcept;
  void judge() noexcept;
  void judge_return(bool is_seen) noexcept;
  void judge_pulse(bool is_seen) noexcept;
  void refine() noexcept;
  [[nodiscard]] bool is_alive() const noexcept;
  [[nodiscard]] double noise_in() const noexcept;
  /// What counts as motion of this pulse.
  [[nodiscard]] double needed_in() const noexcept;
  /// Means that the pulse, its settling and a mean take: the drift over so many is taken off.
  [[nodiscard]] double means_across() const noexcept { return (mean_s_ + kSettling_s + pulse_s_) / mean_s_; }

  double half_range_V_;
  double most_V_;
  double full_slope_V_per_s_;  ///< without the slew limit
  double slope_V_per_s_;
  double period_s_;
  double direction_ = 1.0;
  Result result_ = Result::none;
  Phase phase_ = Phase::before;
  double phase_s_ = 0.0;
  double last_Vs_;        ///< of the last pulse
  double farthest_Vs_;    ///< of the last one where the sensor is alive
  double area_Vs_ = 0.0;  ///< of the pulse in the asked direction
  double first_Vs_ = 0.0;
  double seen_Vs_ = 0.0;       ///< the least that moved the rod; 0: none
  double seen_V_ = 0.0;        ///< its peak
  double unseen_Vs_ = 0.0;     ///< the greatest below that did not, tried later; 0: none
  bool is_confirmed_ = false;  ///< it was seen twice
  bool is_last_seen_ = false;  ///< the last pulse since then was seen
  int refinements_ = 0;
  bool is_return_ = false;    ///< the pulse goes the other way
  int returns_in_a_row_ = 0;  ///< the last such pulses that were seen
  double mean_s_ = 0.0;       ///< time of each mean
  double peak_V_ = 0.0;       ///< of the pulse
  double hold_s_ = 0.0;
  double offset_V_ = 0.0;  ///< in the direction of the pulse
  bool is_falling_ = false;
  double held_s_ = 0.0;
  double sum_Vs_ = 0.0;  ///< of all pulses in the asked direction
  double sum_in_ = 0.0;  ///< of the phase
  std::size_t readings_ = 0;
  int means_ = 0;             ///< before the pulse
  double before_in_ = 0.0;    ///< the last of them
  double drift_in_ = 0.0;     ///< from the mean before that to it
  int agreeing_ = 0;          ///< such changes beyond the limit, one after the other, less the first
  bool is_drifting_ = false;  ///< steadily, before this pulse
  double unsteady_s_ = 0.0;
  double after_in_ = 0.0;
  double pulse_s_ = 0.0;
  double moved_in_ = 0.0;
  double filtered_in_ = 0.0;
  double last_in_ = 0.0;
  bool has_last_ = false;
  double variance_in2_ = 0.0;  ///< of the readings' noise
  std::size_t changes_ = 0;
};

}  // namespace eha::place
