// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>
#include <string>

#include "config/rig_config.hpp"

namespace eha::doctor {

/// [following] as one run determines it.
struct FollowingEstimate {
  config::Following following;              ///< to be written into the rig file
  std::array<double, 2> gain_in_per_V_s{};  ///< measured, towards greater and smaller displacement [in/(V s)]
  double dead_band_V = 0.0;                 ///< measured half width [V]
  double null_error_V = 0.0;                ///< standard error of the null [V]
  double explained_percent = 0.0;           ///< share of the motion's variance that the rule explains [%]
  double peak_missing = 0.0;  ///< greatest missing motion of this run under the rule, as a share of its limit
  double peak_excess = 0.0;   ///< the same of motion too much
};

/// Learns how the rod answers the valve from a sound rig's run.
///
/// With u and y through the following check's low-pass filter, the motion in windows of 0.1 s is
///   y(t + w) - y(t) = G_+ int max(0, u - null - db) dt - G_- int max(0, null - db - u) dt
/// Least squares: G is linear; null and db >= 0 are searched on grids that narrow down. The error of the null comes
/// from a jackknife over ten parts of the run. `following` has half of each G, db and 0.05 V, the default limit and no
/// pressure delay, and is tried on the run itself.
/// @param input   applied volts, one a tick [V]   @param output  displacement sampled just before [in], same length
/// @param step_s  tick [s]
/// @throws DataError  the run holds too little to tell: no motion of 0.5 in each way, less than 0.5 s outside the dead
///                    band on a side, a null known worse than 0.03 V, less than 90 % of the motion explained, or a run
///                    that its own rule would stop; says what to play
/// Cost: some seconds for ten minutes of run.
[[nodiscard]] FollowingEstimate estimate_following(std::span<const double> input, std::span<const double> output,
                                                   double step_s);

/// The lines of [following] for a rig file, with what was measured as comments.
[[nodiscard]] std::string to_rig_lines(const FollowingEstimate& estimate);

}  // namespace eha::doctor
