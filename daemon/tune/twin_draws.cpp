// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/tune/twin_draws.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "config/valve_estimate.hpp"
#include "core/inch.hpp"
#include "ident/excitation/portable_draw.hpp"

namespace eha::tune {
namespace {

constexpr double kPascalPerBar = 1e5;
constexpr double kGravity_m_s2 = 9.80665;
constexpr double kLeastStd_V = 0.005;  // variation of null and dead band between runs
constexpr double kLeastGainShare = 0.02;
constexpr double kFastestSpool_Hz = 120.0;
constexpr double kSlowestSpool_Hz = 3.0;

double area_m2(double diameter_mm) { return 0.25 * std::numbers::pi * diameter_mm * diameter_mm * 1e-6; }

}  // namespace

TwinSpread spread_about_fitted(const ident::ValveNumbers& valve) {
  return {.null_V = std::max(kLeastStd_V, valve.null_std),
          .dead_band_V = std::max(kLeastStd_V, valve.dead_band_std),
          .gain_share = std::max(kLeastGainShare, valve.gain_std_share)};
}

TwinSpread spread_about_estimated(const ident::ValveNumbers& valve) {
  TwinSpread spread = spread_about_fitted(valve);
  spread.friction = 0.3;
  spread.oil = 0.3;
  spread.mass = 0.25;
  spread.leakage = 0.4;
  spread.spool = 0.15;
  return spread;
}

TwinGains gains_of(const hal::SimOptions& o) {
  // Steady motion: both edges pass the rod's flow, pressures carry load and friction. With v = o k sqrt q:
  //   q (A1^3 + A2^3) = the excess force of the full supply.
  const double cap = area_m2(o.bore_mm);
  const double ring = cap - area_m2(o.rod_mm);
  const double supply = o.supply_pressure_bar * kPascalPerBar;
  const double tank = o.tank_pressure_bar * kPascalPerBar;
  const double weight = o.moving_mass_kg * kGravity_m_s2;
  const double cubes = cap * cap * cap + ring * ring * ring;
  const double k = o.valve_rated_flow_L_per_min * 1e-3 / 60.0 / std::sqrt(o.valve_rated_drop_bar * kPascalPerBar);
  const auto gain = [&](double force_N) {
    return k * std::sqrt(std::max(0.0, force_N - o.coulomb_friction_N) / cubes) /
           (o.valve_full_scale_V - o.valve_dead_band_V) / kMetrePerInch;
  };
  return {gain(cap * supply - ring * tank - weight), gain(ring * supply - cap * tank + weight)};
}

config::Following following_of(const hal::SimOptions& options, config::Following before) {
  constexpr double kHalf = 0.5;  // the file has half of each gain
  const TwinGains gains = gains_of(options);
  before.gain_positive_in_per_V_s = kHalf * gains.positive;
  before.gain_negative_in_per_V_s = kHalf * gains.negative;
  before.null_V = -options.valve_null_offset_V;
  before.dead_band_V = options.valve_dead_band_V + config::kDeadBandSpare_V;
  before.measured_check.reset();
  before.measured_rig_check.reset();
  return before;
}

hal::SimOptions estimated_twin(const ident::AxisPlant& plant, hal::SimOptions o) {
  const ident::ValveNumbers& valve = plant.valve;
  o.valve_null_offset_V = -valve.null;
  o.valve_dead_band_V = std::min(valve.dead_band, 0.9 * o.valve_full_scale_V);
  const double ratio = valve.gain_negative / valve.gain_positive;
  // A thicker rod leaves less area for retracting: the ratio falls with it.
  double thin = 0.05 * o.bore_mm;
  double thick = 0.9 * o.bore_mm;
  for (int i = 0; i < 50; ++i) {
    o.rod_mm = 0.5 * (thin + thick);
    const TwinGains gains = gains_of(o);
    (gains.negative > ratio * gains.positive ? thin : thick) = o.rod_mm;
  }
  o.valve_rated_flow_L_per_min *= valve.gain_positive / gains_of(o).positive;
  const double lag_s = std::max(plant.inverse.acceleration, 1e-4);
  o.valve_natural_frequency_Hz =
      std::clamp(2.0 * o.valve_damping_ratio / lag_s / (2.0 * std::numbers::pi), kSlowestSpool_Hz, kFastestSpool_Hz);
  return o;
}

std::vector<hal::SimOptions> drawn_twins(const hal::SimOptions& about, const TwinSpread& spread, double lowest_in,
                                         double highest_in, int count, std::uint64_t seed) {
  ident::PortableDraw random(seed);
  std::vector<hal::SimOptions> twins;
  const double spare = 0.05 * (highest_in - lowest_in);
  for (int i = 0; i < count; ++i) {
    hal::SimOptions o = about;
    const auto factor = [&](double std) { return std::exp(std * random.normal()); };
    o.valve_null_offset_V += spread.null_V * random.normal();
    o.valve_dead_band_V =
        std::clamp(o.valve_dead_band_V + spread.dead_band_V * random.normal(), 0.0, 0.9 * o.valve_full_scale_V);
    o.valve_rated_flow_L_per_min *= std::max(0.2, 1.0 + spread.gain_share * random.normal());
    const double friction = factor(spread.friction);
    o.coulomb_friction_N *= friction;
    o.static_friction_N =
        std::max(o.coulomb_friction_N, o.static_friction_N * friction * factor(0.5 * spread.friction));
    o.viscous_friction_N_s_per_mm *= factor(spread.friction);
    o.bulk_modulus_bar *= factor(spread.oil);
    o.moving_mass_kg *= factor(spread.mass);
    o.leakage_cm3_per_s_per_bar *= factor(spread.leakage);
    o.valve_natural_frequency_Hz *= factor(spread.spool);
    // Spread evenly, in another order than the other draws.
    const double place = (static_cast<double>(i * 7 % std::max(1, count)) + random.uniform()) / count;
    o.initial_displacement_in = lowest_in + spare + place * (highest_in - lowest_in - 2.0 * spare);
    o.seed = seed + 1000 + static_cast<std::uint64_t>(i);
    twins.push_back(o);
  }
  return twins;
}

}  // namespace eha::tune
