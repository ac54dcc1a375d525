// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/characterisation.hpp"

#include "config/valve_estimate.hpp"

namespace eha::config {
namespace {

constexpr double kShareAtTheEnds = 0.28;
constexpr double kFreeShareOfTravel = 0.3;
constexpr double kWallShareOfTravel = 0.1;
constexpr double kWallShare = 1.2;
constexpr double kMostShare = 0.6;
constexpr double kWindowShareOfTravel = 0.3;
constexpr double kWidestWindow_in = 2.0;  ///< exploring it takes minutes
constexpr double kFreeShareOfWindow = 0.5;
constexpr double kWallShareOfWindow = 0.3;
constexpr double kUnknownEdgeShare = 0.16;
/// Beyond the dead band of [following], for a null that has moved.
constexpr double kEdgeSpare_V = 0.05;

}  // namespace

Centring centring_of(const RigLimits& limits) noexcept {
  const double half_range_V = 0.5 * (limits.command_max_V - limits.command_min_V);
  const double travel_in = limits.travel_max_in - limits.travel_min_in;
  Centring centring{.middle_in = limits.mid_travel_in(),
                    .gain_V_per_in = kShareAtTheEnds * half_range_V / (0.5 * travel_in),
                    .free_in = kFreeShareOfTravel * travel_in,
                    .wall_V_per_in = kWallShare * half_range_V / (kWallShareOfTravel * travel_in),
                    .most_V = kMostShare * half_range_V};
  if (limits.following) return centring;
  const double window_in = std::min(kWindowShareOfTravel * travel_in, kWidestWindow_in);
  centring.window_in = window_in;
  centring.free_in = kFreeShareOfWindow * window_in;
  centring.wall_V_per_in = kWallShare * half_range_V / (kWallShareOfWindow * window_in);
  return centring;
}

ident::SheetPlan characterisation_plan(const RigConfig& rig) {
  const RigLimits& limits = rig.limits;
  ident::ValveGuess guess{.null_V = limits.safe_V,
                          .edge_V = kUnknownEdgeShare * 0.5 * (limits.command_max_V - limits.command_min_V)};
  if (limits.following) {
    const ValveEstimate valve = valve_estimate(*limits.following);
    guess = {.null_V = valve.null_V,
             .edge_V = limits.following->dead_band_V + kEdgeSpare_V,
             .gain_in_per_V_s = std::max(valve.gain_positive_in_per_V_s, valve.gain_negative_in_per_V_s)};
  }
  return ident::sheet_plan({.step_s = rig.realtime.sample_period_s,
                            .command_min_V = limits.command_min_V,
                            .command_max_V = limits.command_max_V,
                            .slew_V_per_s = limits.slew_V_per_s,
                            .travel_in = limits.travel_max_in - limits.travel_min_in},
                           guess);
}

}  // namespace eha::config
