// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/tune/following_agreement.hpp"

#include <algorithm>
#include <cmath>

#include "ident/model/parameter_text.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::tune {

double shift_beyond_V(double map_error_V) noexcept {
  return std::max(0.0, ident::kShiftOverMapError * map_error_V - config::kSameValve_V);
}

FoundMap found_map(const ident::Model& model) {
  constexpr double kOfLeast = 2.0;
  const double widening = model.verdict && ident::may_miss_a_part(*model.verdict) ? kOfLeast : 1.0;
  const auto half_width = [&](ident::ParameterRole role) {
    const auto found = std::find_if(model.parameters.begin(), model.parameters.end(),
                                    [&](const auto& parameter) { return parameter.role == role; });
    return found == model.parameters.end() ? 0.0 : widening * ident::half_width95(*found);
  };
  return {.zone = {model.input_map->null, model.input_map->dead_band},
          .half_width = {half_width(ident::ParameterRole::valve_null), half_width(ident::ParameterRole::dead_band)},
          .map_error_V = ident::reported_map_error(model)};
}

FollowingAgreement agreement_of(const config::Following& following, const FoundMap& found) noexcept {
  constexpr double kStds = 2.0;  // of [following], beside the difference of one valve
  const config::ValveEstimate known = config::valve_estimate(following);
  const config::ValveUncertainty uncertainty = config::valve_uncertainty(following);
  const config::DeadZone zone{known.null_V, known.dead_band_V};
  config::DeadZone slack{kStds * uncertainty.null_V, kStds * uncertainty.dead_band_V};
  if (config::is_of_one_valve(zone, found.zone, slack)) return FollowingAgreement::one_valve;
  slack = {std::hypot(slack.null_V, found.half_width.null_V),
           std::hypot(slack.dead_band_V, found.half_width.dead_band_V)};
  if (config::is_of_one_valve(zone, found.zone, slack)) return FollowingAgreement::within_interval;
  const double shift_V = shift_beyond_V(found.map_error_V);
  return config::is_of_one_valve(zone, found.zone, {slack.null_V + shift_V, slack.dead_band_V + shift_V})
             ? FollowingAgreement::within_map_error
             : FollowingAgreement::other_valve;
}

bool is_of_one_valve(const config::DeadZone& measured, const FoundMap& found) noexcept {
  const double shift_V = shift_beyond_V(found.map_error_V);
  return config::is_of_one_valve(measured, found.zone,
                                 {found.half_width.null_V + shift_V, found.half_width.dead_band_V + shift_V});
}

}  // namespace eha::tune
