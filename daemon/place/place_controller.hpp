// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/rig_config.hpp"
#include "daemon/acquisition/limit_monitor.hpp"
#include "daemon/place/loop_monitor.hpp"
#include "hal/rig.hpp"

namespace eha::place {

inline constexpr double kTolerance_in = 0.02;  ///< a rod so near is in its place
inline constexpr double kSettled_s = 0.5;      ///< once it has been so near for so long

/// How long a placing may take [s]: twice the way at the speed that the bounds of its volts allow, and 20 s for finding
/// the valve's null and dead band.
[[nodiscard]] double placing_time_s(const config::RigLimits& limits, double way_in) noexcept;

/// Moves the rod slowly to a place and keeps it there:
///   w = clamp(1.5/s e, +-speed), e = target - y;   u = b + w / g + d clamp(w / 0.02 in/s, +-1);   b' = (3/s / g) (w -
///   v)
/// y the displacement [in], v its slope filtered over 0.1 s, u the command [V]. g, d and the start of b are gain, dead
/// band and null of the rig's [following]; without it g is a third of the greatest gain that the limits allow, d = 0,
/// and b starts at the safe voltage. The integral b corrects errors of these numbers; it stands while the bounds hold u
/// back. w = 0 within 5/1000 in, so that the rod rests. The bounds of u, and what ends a placing, are LoopMonitor's.
/// The limits of the tick come after it, as after every source. Real-time safe. Not thread-safe.
class PlaceController {
 public:
  /// @param target_in  within the allowed travel
  PlaceController(const config::RigLimits& limits, double period_s, double target_in) noexcept;

  /// See LoopMonitor.
  void go_on_from(const acquisition::LackingWay& lacking) noexcept { monitor_.go_on_from(lacking); }
  [[nodiscard]] const acquisition::LackingWay& lacking() const noexcept { return monitor_.lacking(); }

  /// The command of one tick [V].
  [[nodiscard]] double voltage_V(const hal::RigReading& last) noexcept;

  [[nodiscard]] bool is_in_place() const noexcept { return settled_s_ >= kSettled_s; }
  /// Why the rod must not be moved on; see LoopMonitor.
  [[nodiscard]] const acquisition::Breach& breach() const noexcept { return monitor_.breach(); }
  /// The fault of a time-out now: the rod does not move, or has not come to rest at its place.
  [[nodiscard]] acquisition::Breach failure() const noexcept;
  /// Of the first command [in]. Valid after it.
  [[nodiscard]] double way_in() const noexcept;

 private:
  double period_s_;
  double target_in_;
  double speed_in_per_s_;
  double gain_positive_in_per_V_s_;
  double gain_negative_in_per_V_s_;
  double dead_band_V_;
  LoopMonitor monitor_;
  double bias_V_;
  bool has_begun_ = false;
  double start_in_ = 0.0;
  double filtered_in_ = 0.0;
  double steady_in_per_s_ = 0.0;  ///< the velocity filtered once more: a noisy sensor's rod can be seen to rest
  double settled_s_ = 0.0;
};

}  // namespace eha::place
