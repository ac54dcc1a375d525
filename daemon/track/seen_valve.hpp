// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/display_unit.hpp"
#include "ident/control/axis_controller.hpp"

// The valve that the motion of a rod shows.

namespace eha::track {

/// Length of the means about each row, which reduce the readings' noise.
inline constexpr double kMean_s = 0.05;

/// Rows of such a mean.
[[nodiscard]] std::size_t mean_width(double tick_s);

/// Means of `width` values about each row; shorter at the ends.
[[nodiscard]] std::vector<double> means(const std::vector<double>& values, std::size_t width);

inline constexpr const char* kGainUnit = "in/(V s)";

/// Valve from the rod's motion, by least squares over the rows in which the rod moves:
///   u = null + d dead_band + v / gain(d) + T v'   d the direction of the speed v
struct SeenValve {
  double null_V = 0.0;
  double dead_band_V = 0.0;
  double gain_positive_in_per_V_s = 0.0;
  double gain_negative_in_per_V_s = 0.0;
  double null_std_V = 0.0;         ///< of the fit; correlated with that of the dead band
  double dead_band_std_V = 0.0;    ///< the same
  double gain_positive_std = 0.0;  ///< share of the gain
  double gain_negative_std = 0.0;  ///< the same
};

/// @param command_V  a row a tick   @param rod_in  as means of mean_width() rows
/// @returns all 0 where the rod did not move both ways
[[nodiscard]] SeenValve seen_valve(const std::vector<double>& command_V, const std::vector<double>& rod_in,
                                   double tick_s);

/// Compares a seen valve with the controller's, a phrase each where they are four standard deviations apart or more,
/// that of null and dead band first which is the farther in them. The other one of the two is left out where it is not
/// a third as far: little motion one way gives both an error.
[[nodiscard]] std::vector<std::string> changes_of(const SeenValve& seen, const ident::InverseMap& map,
                                                  const DisplayUnit& unit);

}  // namespace eha::track
