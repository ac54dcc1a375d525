// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "config/rig_config.hpp"
#include "ident/valve/sheet_plan.hpp"

namespace eha::config {

/// Of its rows a run may lack so many and still give a valve sheet [%].
inline constexpr double kMostLostRows_percent = 1.0;

/// A valve of which nothing is known is explored slowly before its sheet is played: for at most so long [s].
inline constexpr double kLongestExploring_s = 900.0;

/// The loop that keeps the rod near mid-travel while its valve is characterised: a low gain near the middle and a high
/// gain towards the ends, so that an unknown null does not move the rod to a limit.
///   correction = clamp(gain off + wall (off beyond +-free), +-most),   off = middle - y
struct Centring {
  double middle_in = 0.0;
  double gain_V_per_in = 0.0;
  double free_in = 0.0;
  double wall_V_per_in = 0.0;
  double most_V = 0.0;
  /// Without [following]: to each side of the middle, explored slowly before, and left by nothing that is played [in]
  std::optional<double> window_in = {};

  /// Real-time safe. @returns [V]
  [[nodiscard]] double correction_V(double displacement_in) const noexcept {
    const double off_in = middle_in - displacement_in;
    const double beyond_in = std::copysign(std::max(0.0, std::abs(off_in) - free_in), off_in);
    return std::clamp(gain_V_per_in * off_in + wall_V_per_in * beyond_in, -most_V, most_V);
  }
};

/// Of a rig: 0.28 of half the command range at the travel's ends; from 0.3 of the travel on either side of its middle
/// as much again within a tenth of the travel, four times over; at most 0.6 of half the range. Without [following] both
/// lie within a window of 0.3 of the travel on either side, at most 2 in, whose outer fifth stays free.
[[nodiscard]] Centring centring_of(const RigLimits& limits) noexcept;

/// What is played to characterise the rig's valve: about the null of [following] and beyond its dead band; without
/// [following] about the safe voltage and beyond 0.16 of half the command range.
[[nodiscard]] ident::SheetPlan characterisation_plan(const RigConfig& rig);

}  // namespace eha::config
