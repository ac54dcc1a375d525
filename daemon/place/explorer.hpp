// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>

#include "config/rig_config.hpp"
#include "daemon/acquisition/limit_monitor.hpp"
#include "daemon/place/prediction_monitor.hpp"
#include "daemon/place/probe.hpp"
#include "hal/rig.hpp"

namespace eha::place {

/// In travel where the rod has not been [in/s].
inline constexpr double kExploring_in_per_s = 0.028;

/// Travel where the rod has been, as the sensor shows it, and the middle of the valve's dead band.
struct Explored {
  double lowest_in = 0.0;
  double highest_in = 0.0;
  double null_V = 0.0;
};

/// Moves the rod of a rig without [following] about the middle of its travel before anything faster does, so that
/// neither a wrong scale of the sensor nor an unknown gain of the valve lets it hit an end stop:
///   unexplored travel  0.028 in/s as measured: less than 0.1 in/s for a scale that is wrong by 2.5
///   explored travel    0.1 in/s, from 0.12 in inside
/// The command u grows and shrinks by the error of the measured speed, at most 0.012 of half the command range a
/// second: a rod of 2 in/(V s) gains 0.02 in/s before its speed is known. Where the rod moves out of explored travel,
/// u is what gave 0.028 in/s before. From where the rod stands it goes to the top of the window, to its bottom and to
/// its middle; the window is the middle of the travel and config::Centring::window_in to each side. Before the rod
/// moves in a direction for the first time, pulses show that the sensor sees it (Probe). Where the volts have moved the
/// rod before, they grow no further while it stands. Trips:
///   no_motion           no pulse moves the rod; a rod that moved stands for 4 s, or for 1 s under volts that moved it;
///                       it does not move at the greatest command
///   unexplained_motion  it moves 0.3 in the wrong way
///   those of PredictionMonitor
///   loop_speed          it moves at more than 0.6 in/s
///   not_in_place        it is not done after 15 min
/// Real-time safe. Not thread-safe.
class Explorer {
 public:
  Explorer(const config::RigLimits& limits, double window_in, double period_s) noexcept;

  /// The command of one tick [V]. @param last  the last good reading
  [[nodiscard]] double voltage_V(const hal::RigReading& last) noexcept;

  /// The rod rests in the middle.
  [[nodiscard]] bool is_done() const noexcept { return rested_s_ >= kRest_s; }
  [[nodiscard]] const Explored& explored() const noexcept { return explored_; }
  [[nodiscard]] const acquisition::Breach& breach() const noexcept {
    return breach_.fault == acquisition::Fault::none ? monitor_.breach() : breach_;
  }
  /// With what exploring has shown of the valve; its lines are of the whole command.
  [[nodiscard]] const PredictionMonitor& monitor() const noexcept { return monitor_; }
  /// The command that gave the slow speed in a direction (0 extending, 1 retracting) [V]
  [[nodiscard]] double slow_V(std::size_t direction) const noexcept { return slow_V_[direction]; }

 private:
  static constexpr double kRest_s = 1.0;
  static constexpr std::size_t kMostLegs = 3;

  void begin(double place_in) noexcept;
  void begin_leg() noexcept;
  void filter(double place_in) noexcept;
  void drive() noexcept;
  /// The command that the pulses of a direction are about [V]: the safe voltage, or the other direction's slow one
  /// where the safe voltage drives the rod faster that way.
  [[nodiscard]] double pulsed_about_V() const noexcept;
  void probe(double place_in) noexcept;
  /// Whether the command is one that has moved the rod in the leg's direction before.
  [[nodiscard]] bool is_motion_due() const noexcept;
  void learn(double speed_in_per_s) noexcept;
  void check() noexcept;
  void trip(const acquisition::Breach& breach) noexcept;
  [[nodiscard]] double change_V_per_s(double speed_in_per_s, double wanted_in_per_s, bool is_inside) noexcept;

  double lowest_wanted_in_;
  double middle_in_;
  double highest_wanted_in_;
  double safe_V_;
  double most_V_;        ///< greatest |u - safe|
  double half_range_V_;  ///< of the command
  double period_s_;
  double weight_;  ///< of the low-pass filters
  bool has_begun_ = false;
  std::array<double, kMostLegs> targets_in_{};
  std::size_t legs_ = 0;
  std::size_t leg_ = 0;
  double direction_ = 1.0;
  double command_V_;
  double filtered_in_ = 0.0;
  double speed_in_per_s_ = 0.0;     ///< measured, filtered twice
  double wanted_in_per_s_ = 0.0;    ///< of the tick before
  double quick_share_per_s_ = 0.0;  ///< of half the command range, against a rod that runs away
  double quick_sign_ = 0.0;         ///< of the last such change
  std::array<double, 2> slow_V_{};  ///< that gave the slow speed, upwards and downwards
  std::array<double, 2> slow_s_{};  ///< for so long
  double from_in_ = 0.0;            ///< where the leg began
  double best_in_ = 0.0;            ///< way of the leg so far
  double still_s_ = 0.0;            ///< since it grew
  double still_from_in_ = 0.0;
  double rested_s_ = 0.0;
  double elapsed_s_ = 0.0;
  Explored explored_;
  acquisition::Breach breach_;
  Probe probe_;
  bool is_probing_ = false;
  std::array<double, 2> seen_V_{};  ///< from the safe voltage, that a pulse moved the rod by; 0: not known
  double due_s_ = 0.0;              ///< of a rod that stands although its motion is due
  PredictionMonitor monitor_;
};

}  // namespace eha::place
