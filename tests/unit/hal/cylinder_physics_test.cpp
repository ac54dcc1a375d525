// SPDX-License-Identifier: GPL-3.0-or-later
// The simulated cylinder against the physics that its header states: oscillation, balances, stick-slip, convergence.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "hal/sim/cylinder.hpp"
#include "paper_multisine.hpp"

namespace eha::hal {
namespace {

constexpr double kGravity_m_s2 = 9.80665;
constexpr double kLaminarDrop_Pa = 0.2e5;

struct Geometry {
  explicit Geometry(const SimOptions& o)
      : cap_m2(std::numbers::pi / 4.0 * o.bore_mm * o.bore_mm * 1e-6),
        rod_m2(cap_m2 - std::numbers::pi / 4.0 * o.rod_mm * o.rod_mm * 1e-6),
        options(o) {}
  [[nodiscard]] double cap_m3(const CylinderState& s) const {
    return options.cap_dead_volume_cm3 * 1e-6 + cap_m2 * s.displacement_m;
  }
  [[nodiscard]] double rod_m3(const CylinderState& s) const {
    return options.rod_dead_volume_cm3 * 1e-6 + rod_m2 * (options.stroke_mm * 1e-3 - s.displacement_m);
  }
  double cap_m2;
  double rod_m2;
  SimOptions options;
};

/// Flow into the cap and the rod chamber through the valve [m^3/s], by the orifice equation.
std::pair<double, double> valve_flows(const SimOptions& o, const CylinderState& s) {
  const double opening =
      std::clamp((std::abs(s.spool_V) - o.valve_dead_band_V) / (o.valve_full_scale_V - o.valve_dead_band_V), 0.0, 1.0);
  const double gain = opening * o.valve_rated_flow_L_per_min / 60e3 / std::sqrt(o.valve_rated_drop_bar * 1e5);
  const auto edge = [&](double drop_Pa) { return gain * drop_Pa / std::sqrt(std::hypot(drop_Pa, kLaminarDrop_Pa)); };
  const double supply_Pa = o.supply_pressure_bar * 1e5;
  const double tank_Pa = o.tank_pressure_bar * 1e5;
  if (s.spool_V > 0.0) return {edge(supply_Pa - s.cap_pressure_Pa), -edge(s.rod_pressure_Pa - tank_Pa)};
  return {-edge(s.cap_pressure_Pa - tank_Pa), edge(supply_Pa - s.rod_pressure_Pa)};
}

SimOptions without_friction() {
  SimOptions o;
  o.coulomb_friction_N = 0.0;
  o.static_friction_N = 0.0;
  o.viscous_friction_N_s_per_mm = 0.0;
  return o;
}

TEST(CylinderPhysics, OscillatesAtTheFrequencyOfItsOilAndMass) {
  SimOptions o = without_friction();
  o.leakage_cm3_per_s_per_bar = 0.0;
  o.sub_step_us = 20.0;
  const Geometry g(o);
  for (const double mass_kg : {20.0, 60.0}) {
    o.moving_mass_kg = mass_kg;
    Cylinder cylinder(o);
    cylinder.advance(2.0, Ports::open, 0.03);
    const CylinderState& s = cylinder.state();
    // The rod swings about the position in which the trapped oil carries it; each rising zero of the speed is a period.
    std::vector<double> rising_s;
    double position_sum_m = 0.0;
    double before = s.velocity_m_s;
    constexpr double kStep_s = 1e-4;
    constexpr int kSteps = 5000;
    for (int k = 1; k <= kSteps; ++k) {
      cylinder.advance(0.0, Ports::blocked, kStep_s);
      if (before <= 0.0 && s.velocity_m_s > 0.0) {
        rising_s.push_back(kStep_s * (k - s.velocity_m_s / (s.velocity_m_s - before)));
      }
      before = s.velocity_m_s;
      position_sum_m += s.displacement_m;
    }
    CylinderState middle;
    middle.displacement_m = position_sum_m / kSteps;
    const double stiffness_N_m =
        o.bulk_modulus_bar * 1e5 * (g.cap_m2 * g.cap_m2 / g.cap_m3(middle) + g.rod_m2 * g.rod_m2 / g.rod_m3(middle));
    const double expected_Hz = std::sqrt(stiffness_N_m / mass_kg) / (2.0 * std::numbers::pi);
    ASSERT_GT(rising_s.size(), 20U);
    const double found_Hz = static_cast<double>(rising_s.size() - 1) / (rising_s.back() - rising_s.front());
    EXPECT_NEAR(found_Hz, expected_Hz, 2e-3 * expected_Hz) << mass_kg << " kg";
  }
}

TEST(CylinderPhysics, BalancesFlowAndEnergyToAThousandth) {
  const SimOptions o;
  const Geometry g(o);
  Cylinder cylinder(o);
  const CylinderState& s = cylinder.state();
  // Trapezoidal sums over steps of 50 us; the totals are of absolute values, so that nothing cancels.
  constexpr double kStep_s = 50e-6;
  double cap_error_m3 = 0.0;
  double rod_error_m3 = 0.0;
  double passed_m3 = 0.0;
  double energy_error_J = 0.0;
  double work_J = 0.0;
  const auto rates = [&] {
    const auto [cap_flow, rod_flow] = valve_flows(o, s);
    const double leak = o.leakage_cm3_per_s_per_bar * 1e-11 * (s.cap_pressure_Pa - s.rod_pressure_Pa);
    const double v_mm_s = s.velocity_m_s * 1e3;
    const double dry = o.coulomb_friction_N + (o.static_friction_N - o.coulomb_friction_N) /
                                                  (1.0 + std::pow(v_mm_s / o.stribeck_velocity_mm_per_s, 2));
    const double friction_N =
        dry * v_mm_s / std::hypot(v_mm_s, o.friction_regularisation_mm_per_s) + o.viscous_friction_N_s_per_mm * v_mm_s;
    const double push_N = s.cap_pressure_Pa * g.cap_m2 - s.rod_pressure_Pa * g.rod_m2;
    return std::array{cap_flow - leak, rod_flow + leak, push_N * s.velocity_m_s, friction_N * s.velocity_m_s};
  };
  const double bulk_Pa = o.bulk_modulus_bar * 1e5;
  const auto energy_J = [&] {
    return 0.5 * o.moving_mass_kg * s.velocity_m_s * s.velocity_m_s +
           o.moving_mass_kg * kGravity_m_s2 * s.displacement_m;
  };
  for (int second = 0; second < 10; ++second) {
    for (int ms = 0; ms < 1000; ++ms) {
      const double command_V = testing::paper_multisine_V(second * 1000 + ms);
      for (int part = 0; part < 20; ++part) {
        const CylinderState old = s;
        const auto before = rates();
        const double energy_before_J = energy_J();
        cylinder.advance(command_V, Ports::open, kStep_s);
        const auto after = rates();
        const auto mean = [&](std::size_t i) { return 0.5 * kStep_s * (before[i] + after[i]); };
        // beta dp = -V (dV - Q dt)/V: what enters swells the chamber or compresses its oil.
        const double cap_m3 = 0.5 * (g.cap_m3(old) + g.cap_m3(s));
        const double rod_m3 = 0.5 * (g.rod_m3(old) + g.rod_m3(s));
        cap_error_m3 +=
            mean(0) - (g.cap_m3(s) - g.cap_m3(old)) - cap_m3 / bulk_Pa * (s.cap_pressure_Pa - old.cap_pressure_Pa);
        rod_error_m3 +=
            mean(1) - (g.rod_m3(s) - g.rod_m3(old)) - rod_m3 / bulk_Pa * (s.rod_pressure_Pa - old.rod_pressure_Pa);
        passed_m3 += std::abs(mean(0));
        energy_error_J += mean(2) - mean(3) - (energy_J() - energy_before_J);
        work_J += std::abs(mean(2));
      }
    }
  }
  EXPECT_GT(passed_m3, 3e-5);
  EXPECT_LT(std::abs(cap_error_m3), 1e-3 * passed_m3);
  EXPECT_LT(std::abs(rod_error_m3), 1e-3 * passed_m3);
  EXPECT_GT(work_J, 5.0);
  EXPECT_LT(std::abs(energy_error_J), 1e-3 * work_J);
}

/// Least and greatest speed over its mean, after the start, at a constant command.
std::pair<double, double> ripple(const SimOptions& o, double command_V, double duration_s) {
  Cylinder cylinder(o);
  cylinder.advance(command_V, Ports::open, 0.3 * duration_s);
  double least = 1e300;
  double greatest = -1e300;
  const double from_m = cylinder.state().displacement_m;
  const int steps = static_cast<int>(0.7 * duration_s / 1e-3);
  for (int k = 0; k < steps; ++k) {
    cylinder.advance(command_V, Ports::open, 1e-3);
    least = std::min(least, cylinder.state().velocity_m_s);
    greatest = std::max(greatest, cylinder.state().velocity_m_s);
  }
  const double mean = (cylinder.state().displacement_m - from_m) / (steps * 1e-3);
  return {least / mean, greatest / mean};
}

SimOptions sticky() {
  SimOptions o;
  o.coulomb_friction_N = 200.0;
  o.static_friction_N = 400.0;
  o.stribeck_velocity_mm_per_s = 2.0;
  o.friction_regularisation_mm_per_s = 0.5;
  o.sub_step_us = 25.0;
  return o;
}

TEST(CylinderPhysics, SlidesEvenlyWhereViscousFrictionPrevails) {
  // At 15 mm/s the friction rises with speed; then the steady motion is stable.
  for (const SimOptions& o : {SimOptions{}, sticky()}) {
    const auto [least, greatest] = ripple(o, 4.5, 3.0);
    EXPECT_GT(least, 0.99);
    EXPECT_LT(greatest, 1.01);
  }
}

TEST(CylinderPhysics, SticksAndSlipsAtLowSpeedWithDrySeals) {
  const SimOptions o = sticky();
  constexpr double command_V = 2.0;
  const auto [least, greatest] = ripple(o, command_V, 4.0);
  EXPECT_LT(least, 0.3);
  EXPECT_GT(greatest, 1.7);
  // Far from the onset of the oscillation its size hangs neither on the integration step nor on a hundredth of mass.
  SimOptions finer = o;
  finer.sub_step_us = 0.5 * o.sub_step_us;
  EXPECT_NEAR(ripple(finer, command_V, 4.0).second, greatest, 0.03 * greatest);
  SimOptions heavier = o;
  heavier.moving_mass_kg *= 1.01;
  EXPECT_NEAR(ripple(heavier, command_V, 4.0).second, greatest, 0.05 * greatest);
}

TEST(CylinderPhysics, ImplicitStepsOfHalfAMillisecondMoveTheRodAsTheFineOnesDo) {
  SimOptions stiff;  // a light rod on hard oil
  stiff.bulk_modulus_bar = 9000.0;
  stiff.moving_mass_kg = 10.0;
  // A rod that sticks and slips leaves each stick at a moment that depends on everything before.
  for (const auto& [o, allowed_m] :
       {std::pair{SimOptions{}, 2.5e-6}, std::pair{stiff, 2.5e-6}, std::pair{sticky(), 5e-5}}) {
    SimOptions fine = o;
    fine.sub_step_us = 0.2 * o.sub_step_us;
    Cylinder a(fine);
    Cylinder b(o);
    double greatest_m = 0.0;
    double way_m = 0.0;
    for (int k = 0; k < 20000; ++k) {
      // Large motions, then reversals about the dead band.
      const double t = 1e-3 * k;
      const double command_V = k < 10000 ? 2.5 * std::sin(3.0 * t) + 0.3 * std::sin(44.0 * t)
                                         : -o.valve_null_offset_V + 1.3 * o.valve_dead_band_V * std::sin(9.0 * t);
      const double before_m = a.state().displacement_m;
      a.advance(command_V, Ports::open, 1e-3);
      b.advance_implicitly(command_V, Ports::open, 1e-3);
      greatest_m = std::max(greatest_m, std::abs(a.state().displacement_m - b.state().displacement_m));
      way_m += std::abs(a.state().displacement_m - before_m);
    }
    EXPECT_GT(way_m, 0.05);
    EXPECT_LT(greatest_m, allowed_m);
  }
}

TEST(CylinderPhysics, ImplicitStepsAreHeldByTheEndStops) {
  for (const double command_V : {5.0, -5.0}) {
    const SimOptions o;
    Cylinder cylinder(o);
    for (int k = 0; k < 20000; ++k) cylinder.advance_implicitly(command_V, Ports::open, 1e-3);
    const double x_m = cylinder.state().displacement_m;
    EXPECT_LT(std::max(-x_m, x_m - o.stroke_mm * 1e-3), 2e-4);
    EXPECT_LT(std::abs(cylinder.state().velocity_m_s), 1e-6);
  }
}

TEST(CylinderPhysics, HalvingTheSubStepMovesNoShippedKindOfRigByMoreThanTenThousandthOfItsStroke) {
  SimOptions leaky;
  leaky.leakage_cm3_per_s_per_bar = 0.1;
  SimOptions worn;
  worn.valve_dead_band_V = 0.3;
  worn.valve_null_offset_V = 0.35;
  worn.leakage_cm3_per_s_per_bar = 0.03;
  for (const SimOptions& o : {sticky(), leaky, worn}) {
    ASSERT_TRUE(check(o).empty());
    SimOptions halved = o;
    halved.sub_step_us = 0.5 * o.sub_step_us;
    Cylinder a(o);
    Cylinder b(halved);
    double greatest_m = 0.0;
    for (int k = 0; k < 10000; ++k) {
      const double command_V = testing::paper_multisine_V(k);
      a.advance(command_V, Ports::open, 1e-3);
      b.advance(command_V, Ports::open, 1e-3);
      greatest_m = std::max(greatest_m, std::abs(a.state().displacement_m - b.state().displacement_m));
    }
    EXPECT_LT(greatest_m, 1e-4 * o.stroke_mm * 1e-3);
  }
}

}  // namespace
}  // namespace eha::hal
