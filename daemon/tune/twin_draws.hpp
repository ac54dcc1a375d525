// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "config/rig_config.hpp"
#include "hal/sim/sim_options.hpp"
#include "ident/control/axis_design.hpp"

namespace eha::tune {

/// Standard deviations of drawn twins about their centre.
struct TwinSpread {
  double null_V = 0.02;
  double dead_band_V = 0.02;
  double gain_share = 0.03;
  double friction = 0.1;  ///< of the logarithm, as the next ones
  double oil = 0.1;
  double mass = 0.1;
  double leakage = 0.1;
  double spool = 0.1;
};

/// Returns the spread about a twin that was fitted to a record, or is the rig itself: as in
/// daemon/replay/twin_trial.hpp, with the valve's uncertainty.
[[nodiscard]] TwinSpread spread_about_fitted(const ident::ValveNumbers& valve);
/// Returns the spread about a twin of which only valve and lag were measured: friction, oil, mass and leakage are
/// unknown.
[[nodiscard]] TwinSpread spread_about_estimated(const ident::ValveNumbers& valve);

/// Returns a simulated cylinder with the null, dead band, two gains and lag of a plant, otherwise like `base`; chooses
/// rated flow, rod and spool accordingly.
/// @param base  converters, sensor, travel and all quantities that no measurement determines
[[nodiscard]] hal::SimOptions estimated_twin(const ident::AxisPlant& plant, hal::SimOptions base);

/// Speed of the loaded rod over volts beyond the dead band at small openings, each way [in/(V s)].
struct TwinGains {
  double positive = 0.0;
  double negative = 0.0;
};
[[nodiscard]] TwinGains gains_of(const hal::SimOptions& options);

/// Returns [following] with null, dead band and gains of a simulated rig. Its other numbers stay; sums over measured
/// ones are left out.
[[nodiscard]] config::Following following_of(const hal::SimOptions& options, config::Following before);

/// Draws `count` twins; their first positions are spread over the travel, less a twentieth at each end.
[[nodiscard]] std::vector<hal::SimOptions> drawn_twins(const hal::SimOptions& about, const TwinSpread& spread,
                                                       double lowest_in, double highest_in, int count,
                                                       std::uint64_t seed);

}  // namespace eha::tune
