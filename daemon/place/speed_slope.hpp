// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "daemon/place/forgetting_line.hpp"

namespace eha::place {

/// Finds a sensor's slope, or a rod's gain, that has fallen to about half while the volts swing about a value a little
/// outside the dead band. There an error of the null makes up for a part of the speed that is missing, so that the
/// speed alone shows nothing; how it grows with the volts does not depend on the null. Over the last second of motion
/// in one direction, v the measured speed and w the one that the volts should give:
///   low where  slope of v over w + 2 standard errors < 0.7  and  mean v < 0.7 mean w   for 0.2 s
/// A valve that flattens has a low slope, and a null that is wrong a low mean, but neither both. Counted from 0.2 s
/// after the valve opened; needs 0.3 s of it and a spread of w of 0.02 in/s. Real-time safe; cost: some thirty
/// operations. Not thread-safe.
class SpeedSlope {
 public:
  explicit SpeedSlope(double period_s) noexcept;

  /// Once a tick.
  /// @param direction  1 or -1
  /// @param open_V     of the command outside the dead band, filtered once
  /// @param due_in_per_s, speed_in_per_s  w and v in the direction, filtered alike
  void note(double direction, double open_V, double due_in_per_s, double speed_in_per_s) noexcept;

  [[nodiscard]] bool is_low() const noexcept;
  [[nodiscard]] double mean_in_per_s() const noexcept { return mean_in_per_s_; }
  [[nodiscard]] double least_mean_in_per_s() const noexcept { return least_mean_in_per_s_; }

 private:
  [[nodiscard]] bool looks_low() noexcept;

  double period_s_;
  double kept_;  ///< of the sums, each tick
  double direction_ = 0.0;
  double open_s_ = 0.0;
  ForgettingLine line_;  ///< of v over w
  double low_s_ = 0.0;
  double mean_in_per_s_ = 0.0;
  double least_mean_in_per_s_ = 0.0;
};

}  // namespace eha::place
