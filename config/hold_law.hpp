// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

#include "config/rig_config.hpp"

namespace eha::config {

/// Correction that a hold adds to the volts of its table: clamp(gain e, +-most), e the predicted less the measured
/// displacement.
struct HoldLaw {
  double gain_V_per_in = 0.0;
  double most_V = 0.0;

  /// Real-time safe. @param off_in  e   @returns [V]
  [[nodiscard]] double correction_V(double off_in) const noexcept {
    return std::clamp(gain_V_per_in * off_in, -most_V, most_V);
  }
};

/// Returns the law for a rig: at most a fifth of half the command range.
[[nodiscard]] inline HoldLaw hold_law(const RigLimits& limits, double gain_V_per_in) noexcept {
  constexpr double kMostShare = 0.2;
  return {.gain_V_per_in = gain_V_per_in, .most_V = kMostShare * 0.5 * (limits.command_max_V - limits.command_min_V)};
}

}  // namespace eha::config
