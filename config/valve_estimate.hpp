// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

#include "config/rig_config.hpp"

namespace eha::config {

/// The valve on an integrating rod as [following] has it, without the margins of the check: the file gives half of each
/// gain, and a dead band that is 0.05 V wider than measured. See FOLLOWING in eha-rig(5).
struct ValveEstimate {
  double gain_positive_in_per_V_s = 0.0;  ///< extending [in/(V s)]
  double gain_negative_in_per_V_s = 0.0;  ///< retracting, positive [in/(V s)]
  double null_V = 0.0;                    ///< [V]
  double dead_band_V = 0.0;               ///< half width [V]

  /// Speed of the rod at a command [in/s].
  [[nodiscard]] double velocity_in_per_s(double command_V) const noexcept {
    const double above_V = std::max(0.0, command_V - null_V - dead_band_V);
    const double below_V = std::max(0.0, null_V - dead_band_V - command_V);
    return gain_positive_in_per_V_s * above_V - gain_negative_in_per_V_s * below_V;
  }
};

[[nodiscard]] inline ValveEstimate valve_estimate(const Following& following) noexcept {
  constexpr double kGainOfHalf = 2.0;
  constexpr double kSpare_V = 0.05;
  return {.gain_positive_in_per_V_s = kGainOfHalf * following.gain_positive_in_per_V_s,
          .gain_negative_in_per_V_s = kGainOfHalf * following.gain_negative_in_per_V_s,
          .null_V = following.null_V,
          .dead_band_V = std::max(0.0, following.dead_band_V - kSpare_V)};
}

}  // namespace eha::config
