// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>

#include "config/rig_config.hpp"
#include "config/valve_estimate.hpp"
#include "daemon/acquisition/limit_monitor.hpp"

namespace eha::track {

/// Reckons from the volts where the rod of a trial may be, whatever its sensor shows: a loop follows a sensor whose
/// slope has fallen, or that drifts, into the end stop at the reference's speed. With v(u) the valve of [following], u
/// and y through the same low-pass filter (0.05 s), g the greater gain, for each direction d, each tick:
///   gap = d (v(u) dt - dy)
///   B = max(0, B + gap - (0.12 |v(u)| + 0.03 V g + 0.003 in/s) dt)    what gain and null of a sound rig do not explain
///   R = R + gap + 0.06 |v(u)| dt where B > 0, else 0                    how much farther the rod may be than it shows
/// wrong_place where B > 0.03 in and a rod at y + d R, at the speed of its volts, could not stop before its travel
/// limit. Real-time safe; cost: some thirty operations. Not thread-safe.
class ReckonedPlace {
 public:
  /// @param limits    without [following] nothing is reckoned
  /// @param period_s  time between two calls of note() [s]
  ReckonedPlace(const config::RigLimits& limits, double period_s);

  /// Once a tick. @param displacement_in  finite [in]   @param applied_V  the voltage held since the reading before [V]
  void note(double displacement_in, double applied_V) noexcept;

  /// Stays once there is one: how much farther the rod may be than it shows, signed, and the travel limit [in].
  [[nodiscard]] const acquisition::Breach& breach() const noexcept { return breach_; }

 private:
  config::RigLimits limits_;
  double period_s_;
  std::optional<config::ValveEstimate> valve_;
  double weight_;         ///< of the low-pass filters
  double null_in_ = 0.0;  ///< what null and dead band may do in a tick
  bool has_begun_ = false;
  double filtered_V_ = 0.0;
  double filtered_in_ = 0.0;
  std::array<double, 2> beyond_in_{};   ///< B, upwards and downwards
  std::array<double, 2> farther_in_{};  ///< R
  acquisition::Breach breach_;
};

}  // namespace eha::track
