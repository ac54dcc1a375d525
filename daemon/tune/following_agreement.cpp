// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/tune/following_agreement.hpp"

#include <algorithm>

#include "ident/validation/map_error.hpp"

namespace eha::tune {

double shift_beyond_V(double map_error_V) noexcept {
  return std::max(0.0, ident::kShiftOverMapError * map_error_V - config::kSameValve_V);
}

FollowingAgreement agreement_of(const config::Following& following, const config::DeadZone& found,
                                double map_error_V) noexcept {
  constexpr double kStds = 2.0;  // of [following], beside the difference of one valve
  const config::ValveEstimate known = config::valve_estimate(following);
  const config::ValveUncertainty uncertainty = config::valve_uncertainty(following);
  const config::DeadZone zone{known.null_V, known.dead_band_V};
  const config::DeadZone slack{kStds * uncertainty.null_V, kStds * uncertainty.dead_band_V};
  if (config::is_of_one_valve(zone, found, slack)) return FollowingAgreement::one_valve;
  const double shift_V = shift_beyond_V(map_error_V);
  return config::is_of_one_valve(zone, found, {slack.null_V + shift_V, slack.dead_band_V + shift_V})
             ? FollowingAgreement::within_map_error
             : FollowingAgreement::other_valve;
}

}  // namespace eha::tune
