// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "config/rig_config.hpp"

namespace eha::config {

/// Estimated valve of an integrating rod, from [following] without the margins of the check: the file gives half of
/// each gain, and a dead band that is 0.05 V wider than measured. See FOLLOWING in eha-rig(5).
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

/// Margin that dead_band_V of [following] has over the measured value.
inline constexpr double kDeadBandSpare_V = 0.05;

[[nodiscard]] inline ValveEstimate valve_estimate(const Following& following) noexcept {
  constexpr double kGainOfHalf = 2.0;
  return {.gain_positive_in_per_V_s = kGainOfHalf * following.gain_positive_in_per_V_s,
          .gain_negative_in_per_V_s = kGainOfHalf * following.gain_negative_in_per_V_s,
          .null_V = following.null_V,
          .dead_band_V = std::max(0.0, following.dead_band_V - kDeadBandSpare_V)};
}

/// Greatest difference of null and dead band of one valve between a sheet, a model's map and a moving rod [V].
inline constexpr double kSameValve_V = 0.03;
/// Returns that difference for a wide dead band: friction bends the edges of a model's map.
[[nodiscard]] inline double same_dead_band_V(double dead_band_V) noexcept {
  constexpr double kShare = 0.15;
  return std::max(kSameValve_V, kShare * dead_band_V);
}

/// Where a valve passes nothing [V].
struct DeadZone {
  double null_V = 0.0;
  double dead_band_V = 0.0;  ///< half width
};

/// Whether two findings are of one valve. @param slack  further difference that each number may have [V]
[[nodiscard]] inline bool is_of_one_valve(const DeadZone& known, const DeadZone& found,
                                          const DeadZone& slack = {}) noexcept {
  return std::abs(found.null_V - known.null_V) <= kSameValve_V + slack.null_V &&
         std::abs(found.dead_band_V - known.dead_band_V) <= same_dead_band_V(known.dead_band_V) + slack.dead_band_V;
}

/// Returns the greatest distance of a closed loop's command from the valve's null [V]: the rig file's value, else a
/// share of half the command range.
[[nodiscard]] inline double closed_loop_most_V(const RigLimits& limits) noexcept {
  constexpr double kShareOfHalfRange = 0.3;
  return limits.closed_loop_max_V.value_or(kShareOfHalfRange * 0.5 * (limits.command_max_V - limits.command_min_V));
}

/// Standard deviations of the numbers of a ValveEstimate.
struct ValveUncertainty {
  double null_V = 0.0;       ///< [V]
  double dead_band_V = 0.0;  ///< [V]
  double gain_share = 0.0;   ///< of each gain
};

/// Returns the uncertainties of [following]; for missing keys 0.02 V, 0.02 V and 3 %, the accuracy of slow steps.
[[nodiscard]] inline ValveUncertainty valve_uncertainty(const Following& following) noexcept {
  constexpr double kStdsOf95Percent = 1.96;
  const auto std_of = [](const std::optional<double>& half_width, double otherwise) {
    return half_width ? *half_width / kStdsOf95Percent : otherwise;
  };
  const double gain_percent = std_of(following.gain_uncertainty_percent, 3.0);
  return {.null_V = std_of(following.null_uncertainty_V, 0.02),
          .dead_band_V = std_of(following.dead_band_uncertainty_V, 0.02),
          .gain_share = 0.01 * gain_percent};
}

}  // namespace eha::config
