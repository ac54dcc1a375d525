// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "config/rig_config.hpp"
#include "config/stopping_distance.hpp"
#include "daemon/acquisition/tick_record.hpp"
#include "hal/rig.hpp"

namespace eha::acquisition {

/// The limit that a reading violates; Fault::none if it violates none.
struct Breach {
  Fault fault = Fault::none;
  double value = 0.0;  ///< in the unit of the limit
  double limit = 0.0;
  // Of no_motion, where they are known: the command and for how long it has asked for motion.
  double driven_V = 0.0;
  double driven_s = 0.0;
};

/// Checks every reading against the rig's limits and the valid band of its sensor. Real-time safe; cost: one pass over
/// 20 ms of readings.
///
/// Velocity v is the slope of the straight line through the last 20 ms of readings (least squares; 0 until there are
/// enough), so that one noisy code gives no speed. Travel is exceeded if the rod is outside, or could not stop inside:
/// x +- config::stopping_distance_in(). A rod that reverses next to an end may pass it by the distance for v = 0 (0.014
/// in at 200 in/s^2) before v shows it. A jump between two readings is also too fast if it exceeds what the rod may
/// cover in the time between them plus 10 ms, or 0.01 in where that is more: only a failing sensor does that. A sensor
/// is frozen when its code stays the same for the rig's time while the command is more than 10 % of half the command
/// range away from the safe voltage; time that is not driven does not count.
class LimitMonitor {
 public:
  LimitMonitor(const config::RigLimits& limits, double period_s) noexcept;

  /// @param at_ns      time of the reading from the run's start, increasing [ns]
  /// @param applied_V  the voltage held since the reading before [V]
  [[nodiscard]] Breach check(std::int64_t at_ns, const hal::RigReading& reading, double applied_V) noexcept;

  /// Call before the first reading: allows a rod beyond a travel limit to move inward. Beyond the limit, the limit
  /// becomes the innermost position that the rod has reached, less 0.1 in for noise; from 0.1 in inside on, the rig's
  /// limit holds.
  void allow_way_back() noexcept { way_back_ = true; }

  /// Speed of the last reading checked [in/s].
  [[nodiscard]] double velocity_in_per_s() const noexcept { return velocity_in_per_s_; }
  /// Whether the last reading was farther from the one before than any rod goes.
  [[nodiscard]] bool has_jumped() const noexcept { return has_jumped_; }

  /// Share of the way to a travel limit at the last reading checked, stopping distance included: 0 in the middle of the
  /// allowed travel, over 1 where it trips.
  [[nodiscard]] double travel_share() const noexcept { return travel_share_; }
  /// Speed of the last reading checked, as a share of the velocity limit.
  [[nodiscard]] double velocity_share() const noexcept {
    return std::abs(velocity_in_per_s_) / limits_.velocity_limit_in_per_s;
  }

 private:
  [[nodiscard]] Breach check_jump(std::int64_t at_ns, double displacement_in) const noexcept;
  void estimate_velocity(std::int64_t at_ns, double displacement_in) noexcept;
  [[nodiscard]] Breach check_travel(double displacement_in) noexcept;
  [[nodiscard]] bool is_frozen(std::int64_t at_ns, std::uint32_t code, double applied_V) noexcept;

  config::RigLimits limits_;
  double period_s_;
  double driven_V_;  ///< the rod must move when the command is further than this from the safe voltage [V]
  std::size_t window_;
  std::array<std::int64_t, config::kLongestVelocityWindow> times_ns_{};
  std::array<double, config::kLongestVelocityWindow> positions_in_{};
  std::size_t readings_ = 0;
  bool way_back_ = false;
  double lower_reached_in_ = 0.0;  ///< on the way back: the innermost places, from below and from above
  double upper_reached_in_ = 0.0;
  bool has_jumped_ = false;
  double velocity_in_per_s_ = 0.0;
  double travel_share_ = 0.0;
  std::uint32_t last_code_ = 0;
  std::int64_t last_at_ns_ = 0;
  double unchanged_s_ = 0.0;
};

}  // namespace eha::acquisition
