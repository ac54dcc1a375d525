// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/sim/cylinder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "paper_multisine.hpp"

namespace eha::hal {
namespace {

constexpr double kGravity_m_s2 = 9.80665;

double cap_area_m2(const SimOptions& o) { return std::numbers::pi / 4.0 * std::pow(o.bore_mm * 1e-3, 2); }
double rod_area_m2(const SimOptions& o) {
  return cap_area_m2(o) - std::numbers::pi / 4.0 * std::pow(o.rod_mm * 1e-3, 2);
}

/// Flow through one edge at a drop of 1 Pa for the command [m^3/s].
double edge_gain(const SimOptions& o, double command_V) {
  const double spool_V = std::abs(command_V + o.valve_null_offset_V);
  const double opening = std::min(1.0, (spool_V - o.valve_dead_band_V) / (o.valve_full_scale_V - o.valve_dead_band_V));
  return opening * o.valve_rated_flow_L_per_min / 60e3 / std::sqrt(o.valve_rated_drop_bar * 1e5);
}

double friction_N(const SimOptions& o, double v_mm_s) {
  const double v = v_mm_s;
  const double dry = o.coulomb_friction_N + (o.static_friction_N - o.coulomb_friction_N) /
                                                (1.0 + std::pow(v / o.stribeck_velocity_mm_per_s, 2));
  return dry * v / std::hypot(v, o.friction_regularisation_mm_per_s) + o.viscous_friction_N_s_per_mm * v;
}

double steady_velocity_m_s(const SimOptions& o, double command_V, double after_s) {
  Cylinder cylinder(o);
  cylinder.advance(command_V, Ports::open, after_s);
  return cylinder.state().velocity_m_s;
}

TEST(Cylinder, ReachesTheSpeedThatTheOrificeEquationGives) {
  SimOptions o;
  o.leakage_cm3_per_s_per_bar = 0.0;
  const double supply_Pa = o.supply_pressure_bar * 1e5;
  const double tank_Pa = o.tank_pressure_bar * 1e5;
  for (const double command_V : {0.8, 2.0, 3.5, -1.0, -2.5}) {
    // With a speed v > 0 each chamber's flow is known, hence each drop, each pressure and the force left over, which
    // falls with v: the steady speed is its zero.
    const double gain = edge_gain(o, command_V);
    const auto force_left_N = [&](double speed) {
      const double cap_drop = std::pow(cap_area_m2(o) * speed / gain, 2);
      const double rod_drop = std::pow(rod_area_m2(o) * speed / gain, 2);
      const double weight = o.moving_mass_kg * kGravity_m_s2;
      const double friction = friction_N(o, speed * 1e3);
      if (command_V + o.valve_null_offset_V > 0.0) {
        return (supply_Pa - cap_drop) * cap_area_m2(o) - (tank_Pa + rod_drop) * rod_area_m2(o) - weight - friction;
      }
      return (supply_Pa - rod_drop) * rod_area_m2(o) - (tank_Pa + cap_drop) * cap_area_m2(o) + weight - friction;
    };
    double low = 0.0;
    double high = 1.0;
    for (int i = 0; i < 100; ++i) {
      const double middle = 0.5 * (low + high);
      (force_left_N(middle) > 0.0 ? low : high) = middle;
    }
    const double simulated = steady_velocity_m_s(o, command_V, 3.0);
    EXPECT_NEAR(std::abs(simulated), low, 1e-4 * low) << command_V << " V";
    EXPECT_EQ(simulated > 0.0, command_V > 0.0);
  }
}

TEST(Cylinder, ExtendsFasterThanItRetractsAsTheAreasSay) {
  SimOptions o;
  o.leakage_cm3_per_s_per_bar = 0.0;
  o.coulomb_friction_N = 0.0;
  o.static_friction_N = 0.0;
  o.viscous_friction_N_s_per_mm = 0.0;
  o.valve_null_offset_V = 0.0;
  o.tank_pressure_bar = 0.0;
  const double ratio = steady_velocity_m_s(o, 2.0, 3.0) / -steady_velocity_m_s(o, -2.0, 3.0);
  // (v_out / v_in)^2 = (p A1 - m g) / (p A2 + m g), from equal valve edges; without weight it is the area ratio.
  const double supply_Pa = o.supply_pressure_bar * 1e5;
  const double weight = o.moving_mass_kg * kGravity_m_s2;
  const double expected = std::sqrt((supply_Pa * cap_area_m2(o) - weight) / (supply_Pa * rod_area_m2(o) + weight));
  EXPECT_NEAR(ratio, expected, 1e-4);
  EXPECT_GT(ratio, 1.1);
}

TEST(Cylinder, CreepsAtZeroVoltsAndStaysInsideTheDeadBand) {
  const SimOptions o;
  const double creep = steady_velocity_m_s(o, 0.0, 2.0);
  EXPECT_GT(creep, 1e-5) << "the null offset is greater than the dead band as shipped";
  EXPECT_LT(std::abs(steady_velocity_m_s(o, -o.valve_null_offset_V, 2.0)), 1e-3 * creep);
}

TEST(Cylinder, IsHeldByItsEndStops) {
  SimOptions o;
  for (const double command_V : {5.0, -5.0}) {
    Cylinder cylinder(o);
    double deepest_m = 0.0;
    for (int k = 0; k < 20000; ++k) {
      cylinder.advance(command_V, Ports::open, 1e-3);
      const double x = cylinder.state().displacement_m;
      deepest_m = std::max({deepest_m, -x, x - o.stroke_mm * 1e-3});
    }
    EXPECT_GT(deepest_m, 0.0) << "the stop was reached";
    EXPECT_LT(deepest_m, 2e-4);
    EXPECT_LT(std::abs(cylinder.state().velocity_m_s), 1e-6);
    const double pressed_Pa = command_V > 0.0 ? cylinder.state().cap_pressure_Pa : cylinder.state().rod_pressure_Pa;
    EXPECT_GT(pressed_Pa, 0.8 * o.supply_pressure_bar * 1e5);
    EXPECT_LE(pressed_Pa, o.supply_pressure_bar * 1e5 * (1.0 + 1e-9));
  }
}

TEST(Cylinder, CarriesItsWeightWithBlockedPorts) {
  SimOptions o;
  o.leakage_cm3_per_s_per_bar *= 20.0;  // reaches its rest in one minute instead of twenty
  Cylinder cylinder(o);
  cylinder.advance(2.0, Ports::open, 1.0);
  cylinder.advance(2.0, Ports::blocked, 0.1);
  const CylinderState start = cylinder.state();
  for (int second = 0; second < 60; ++second) cylinder.advance(5.0, Ports::blocked, 1.0);
  const CylinderState& rest = cylinder.state();
  EXPECT_LT(std::abs(rest.velocity_m_s), 1e-6);
  // Leakage makes the pressures equal; acting on the rod's area alone, they carry the weight.
  const double weight_N = o.moving_mass_kg * kGravity_m_s2;
  EXPECT_NEAR(rest.cap_pressure_Pa, rest.rod_pressure_Pa, 2e3);
  EXPECT_NEAR(rest.cap_pressure_Pa * cap_area_m2(o) - rest.rod_pressure_Pa * rod_area_m2(o), weight_N, 0.5);
  // The compressed oil pushes the rod out by its volume only.
  const double cap_m3 = o.cap_dead_volume_cm3 * 1e-6 + cap_area_m2(o) * start.displacement_m;
  const double rod_m3 = o.rod_dead_volume_cm3 * 1e-6 + rod_area_m2(o) * (o.stroke_mm * 1e-3 - start.displacement_m);
  const double rest_Pa = weight_N / (cap_area_m2(o) - rod_area_m2(o));
  const double released_m3 = ((start.cap_pressure_Pa - rest_Pa) * cap_m3 + (start.rod_pressure_Pa - rest_Pa) * rod_m3) /
                             (o.bulk_modulus_bar * 1e5);
  const double expected_m = released_m3 / (cap_area_m2(o) - rod_area_m2(o));
  EXPECT_NEAR(rest.displacement_m - start.displacement_m, expected_m, 0.1 * expected_m);
}

TEST(Cylinder, KeepsItsOilWhenThePortsAreBlocked) {
  // Leakage moves oil from one chamber to the other; the total, compressed oil included, is constant.
  const SimOptions o;
  Cylinder cylinder(o);
  const auto oil_m3 = [&] {
    const CylinderState& s = cylinder.state();
    const double cap = o.cap_dead_volume_cm3 * 1e-6 + cap_area_m2(o) * s.displacement_m;
    const double rod = o.rod_dead_volume_cm3 * 1e-6 + rod_area_m2(o) * (o.stroke_mm * 1e-3 - s.displacement_m);
    const double bulk_Pa = o.bulk_modulus_bar * 1e5;
    return cap * std::exp(s.cap_pressure_Pa / bulk_Pa) + rod * std::exp(s.rod_pressure_Pa / bulk_Pa);
  };
  cylinder.advance(2.0, Ports::open, 1.0);
  const double before = oil_m3();
  cylinder.advance(0.0, Ports::blocked, 20.0);
  // p' = beta/V (...) conserves V exp(p / beta) of a closed chamber; with leakage the two sides differ in density by p
  // / beta.
  EXPECT_NEAR(oil_m3() / before, 1.0, 2e-5);
}

TEST(Cylinder, HalvingTheSubStepMovesThePaperExperimentByLessThanOneCode) {
  SimOptions shipped;
  SimOptions halved = shipped;
  halved.sub_step_us = shipped.sub_step_us / 2.0;
  Cylinder a(shipped);
  Cylinder b(halved);
  const double code_m = (shipped.feedback_max_V - shipped.feedback_min_V) / 65535.0 * shipped.scale_in_per_V * 0.0254;
  double greatest_m = 0.0;
  double least_travel_m = 1.0;
  for (int k = 0; k < 50000; ++k) {
    const double command_V = testing::paper_multisine_V(k);
    a.advance(command_V, Ports::open, 1e-3);
    b.advance(command_V, Ports::open, 1e-3);
    greatest_m = std::max(greatest_m, std::abs(a.state().displacement_m - b.state().displacement_m));
    least_travel_m =
        std::min({least_travel_m, a.state().displacement_m, shipped.stroke_mm * 1e-3 - a.state().displacement_m});
  }
  EXPECT_LT(greatest_m, code_m);
  EXPECT_GT(least_travel_m, 0.010) << "the rod must not come near an end stop";
  RecordProperty("greatest_difference_in_codes", std::to_string(greatest_m / code_m));
}

}  // namespace
}  // namespace eha::hal
