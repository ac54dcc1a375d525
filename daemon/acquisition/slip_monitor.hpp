// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "daemon/acquisition/limit_monitor.hpp"

namespace eha::acquisition {

/// Sums the jumps by which a sensor's reading leaves the rod's place: a coupling that slips, a wiper that hops. With y
/// and v the reading and its speed before, dt the longest time that may lie between two readings, s the noise:
///   a reading jumps if  J = y_k - y_(k-1) - v dt_k  is beyond  velocity limit dt + 0.01 in + 8 s
/// as no rod moves; 0.05 in stand for 0.01 in + 8 s until 20 readings have shown s. The jumps up to the next 10 ms
/// without one are one step; a step beyond 0.01 in + 8 s counts, so that interference, which comes back, does not.
/// sensor_slip at |sum of the steps| > 0.05 in. Does not detect a slip of less than a jump, or one that takes longer.
/// Real-time safe; cost: some twenty operations. Not thread-safe.
class SlipMonitor {
 public:
  /// @param earlier_in  sum of the runs before [in]
  SlipMonitor(double velocity_limit_in_per_s, double earlier_in) noexcept
      : velocity_limit_in_per_s_(velocity_limit_in_per_s), slipped_in_(earlier_in) {}

  /// @param displacement_in    finite [in]
  /// @param velocity_in_per_s  at the reading before; 0 where none is known [in/s]
  /// @param since_s            time between the readings as scheduled [s]
  /// @param longest_s          the longest that it may have been: a thread may wait before and after a call [s]
  [[nodiscard]] Breach check(double displacement_in, double velocity_in_per_s, double since_s,
                             double longest_s) noexcept;

  /// Sum of the steps, that of the last 10 ms included: the rod is where the sensor shows, less this [in].
  [[nodiscard]] double slipped_in() const noexcept;

 private:
  [[nodiscard]] double noise_in() const noexcept;

  double velocity_limit_in_per_s_;
  double slipped_in_;
  double step_in_ = 0.0;  ///< jumps since the last steady time
  double steady_s_ = 0.0;
  double last_in_ = 0.0;
  double last_change_in_ = 0.0;
  double variance_in2_ = 0.0;  ///< of the readings' noise
  int readings_ = 0;
};

}  // namespace eha::acquisition
