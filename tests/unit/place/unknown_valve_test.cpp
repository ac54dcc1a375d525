// SPDX-License-Identifier: GPL-3.0-or-later
// What protects the first characterisation of a rig of which nothing is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/unit/place/unknown_rig.hpp"

namespace eha::place {
namespace {

/// A rod of a gain [in/(V s)] in mid-travel, its valve closed at 0 V.
Drawn rod_of(double gain_in_per_V_s) {
  Drawn rig;
  rig.gain_in_per_V_s = gain_in_per_V_s;
  rig.plant.valve_rated_flow_L_per_min *= gain_in_per_V_s / 0.14;
  rig.plant.valve_dead_band_V = 0.25;
  rig.plant.scale_in_per_V = 0.35;
  rig.plant.offset_in = 2.95;
  return rig;
}

hal::InjectedFault stuck_from(std::int64_t tick) {
  return {
      .kind = hal::FaultKind::stuck_sensor, .first_tick = tick, .ticks = hal::InjectedFault::kAlways, .noise_LSB = 5.0};
}

TEST(UnknownValve, IsHardlyMovedWhereTheSensorIsDeadFromTheStart) {
  for (const double gain : {0.1, 0.5, 2.0}) {
    const Measured result = measured(rod_of(gain), unknown_rig(), stuck_from(1));
    EXPECT_EQ(result.fault, acquisition::Fault::no_motion) << gain;
    EXPECT_LT(result.way_in, 0.35 * gain) << gain;
    EXPECT_LT(result.at_s, 15.0) << gain;
  }
}

/// One change of a reading is no motion that volts have caused.
TEST(UnknownValve, IsHardlyMovedWhereTheReadingOfADeadSensorHopsOrSettles) {
  for (const double gain : {0.5, 1.4}) {
    for (const double at_s : {0.5, 0.6, 0.7, 0.75, 0.9, 4.0}) {
      Drawn rig = rod_of(gain);
      rig.disturbance = [at_s](double time_s) { return time_s > at_s ? 0.03 : 0.0; };
      const Measured result = measured(rig, unknown_rig(), stuck_from(1));
      EXPECT_NE(result.fault, acquisition::Fault::none) << gain << ", hop at " << at_s << " s";
      EXPECT_LT(result.way_in, 0.35 * gain) << gain << ", hop at " << at_s << " s";
      EXPECT_LT(result.at_s, 20.0) << gain << ", hop at " << at_s << " s";
    }
    for (const double tau_s : {0.5, 1.8}) {
      Drawn rig = rod_of(gain);
      rig.disturbance = [tau_s](double time_s) { return 0.09 * std::expm1(-time_s / tau_s); };
      const Measured result = measured(rig, unknown_rig(), stuck_from(1));
      EXPECT_NE(result.fault, acquisition::Fault::none) << gain << ", settles with " << tau_s << " s";
      EXPECT_LT(result.way_in, 0.35 * gain) << gain << ", settles with " << tau_s << " s";
    }
  }
}

/// The volts that moved the rod first are those of the time at which the pressure came.
TEST(UnknownValve, IsStoppedSoonWhereThePressureIsLateAndTheSensorFreezesThen) {
  Drawn rig = rod_of(1.2);
  rig.plant.valve_dead_band_V = 0.47;
  rig.plant.valve_null_offset_V = 0.18;
  rig.plant.initial_displacement_in = 3.6;
  rig.pressure_delay_s = 10.0;
  const Measured result = measured(rig, unknown_rig(), stuck_from(15'000));
  EXPECT_EQ(result.fault, acquisition::Fault::no_motion);
  EXPECT_LT(result.way_in, 0.6);
  EXPECT_LT(result.impact_in_per_s, 0.1);
}

/// Open at the safe voltage, either way.
TEST(UnknownValve, IsFoundWhereTheRodDriftsAtTheSafeVoltage) {
  for (const double null_V : {0.4, -0.4}) {
    Drawn rig = rod_of(0.6);
    rig.plant.valve_dead_band_V = 0.25;
    rig.plant.valve_null_offset_V = -null_V;
    const Measured result = measured(rig, unknown_rig());
    EXPECT_TRUE(result.is_complete) << null_V << ": " << acquisition::to_text(result.fault) << " at " << result.at_s;
  }
}

TEST(UnknownValve, IsMovedNoFartherByPulsesOfALowSlewLimitOrAWideRange) {
  for (const double half_range_V : {5.0, 10.0}) {
    for (const double slew_V_per_s : {0.5 * half_range_V, 20.0}) {
      config::RigConfig rig = unknown_rig();
      rig.limits.command_min_V = -half_range_V;
      rig.limits.command_max_V = half_range_V;
      rig.limits.slew_V_per_s = slew_V_per_s;
      const Measured result = measured(rod_of(2.0), rig, stuck_from(1));
      EXPECT_EQ(result.fault, acquisition::Fault::no_motion) << half_range_V << " V, " << slew_V_per_s << " V/s";
      EXPECT_LT(result.way_in, slew_V_per_s < 5.0 ? 0.8 : 0.65) << half_range_V << " V, " << slew_V_per_s << " V/s";
    }
  }
}

TEST(UnknownValve, IsFoundAtTheLeastSlewLimitThatIsArmed) {
  config::RigConfig rig = unknown_rig();
  rig.limits.slew_V_per_s = 2.5;
  for (const double gain : {0.14, 1.0}) {
    const Measured result = measured(rod_of(gain), rig);
    EXPECT_TRUE(result.is_complete) << gain << ": " << acquisition::to_text(result.fault) << " at " << result.at_s;
  }
}

/// One edge of the dead band at 0.85 V, the other one at 0.35 V: the pulses the other way show that the sensor is
/// alive.
TEST(UnknownValve, IsFoundAtALowSlewLimitWhereItsNullIsNotInTheMiddle) {
  config::RigConfig rig = unknown_rig();
  rig.limits.slew_V_per_s = 2.5;
  for (const double null_V : {0.25, -0.25}) {
    Drawn rod = rod_of(0.4);
    rod.plant.valve_dead_band_V = 0.6;
    rod.plant.valve_null_offset_V = -null_V;
    const Measured result = measured(rod, rig);
    EXPECT_TRUE(result.is_complete) << null_V << ": " << acquisition::to_text(result.fault) << " at " << result.at_s;
  }
}

/// Between two sines the table changes by 2 V at once, for which 5 V/s takes 0.4 s.
TEST(UnknownValve, IsMeasuredWhereTheSlewLimitHoldsTheTableBack) {
  config::RigConfig rig = unknown_rig();
  rig.limits.slew_V_per_s = 5.0;
  const Measured result = measured(rod_of(0.4), rig);
  EXPECT_TRUE(result.is_complete) << acquisition::to_text(result.fault) << " at " << result.at_s;
}

/// As where the leg before ended in a pulse.
TEST(Probe, TakesNoMotionThatEndsAsItBeginsForThatOfAPulse) {
  Probe probe(unknown_rig().limits, 1.5, 0.001);
  probe.begin(1.0);
  for (int k = 0; k < 30'000 && probe.result() == Probe::Result::none; ++k) {
    (void)probe.offset_V(3.0 + 0.006 * std::exp(-k / 60.0));
  }
  EXPECT_EQ(probe.result(), Probe::Result::unseen);
}

TEST(Probe, EndsWhereTheReadingIsNeverSteady) {
  Probe probe(unknown_rig().limits, 1.5, 0.001);
  probe.begin(1.0);
  double volts_s = 0.0;
  for (int k = 0; k < 30'000 && probe.result() == Probe::Result::none; ++k) {
    volts_s += 0.001 * std::abs(probe.offset_V(k % 300 < 150 ? 3.0 : 3.1));
  }
  EXPECT_EQ(probe.result(), Probe::Result::unsteady);
  EXPECT_LT(volts_s, 0.3);
}

/// The reading goes on steadily, whatever the volts are.
TEST(Probe, TakesASteadyDriftForNoMotion) {
  Probe probe(unknown_rig().limits, 1.5, 0.001);
  probe.begin(1.0);
  for (int k = 0; k < 60'000 && probe.result() == Probe::Result::none; ++k) (void)probe.offset_V(3.0 + 1e-4 * k);
  EXPECT_EQ(probe.result(), Probe::Result::unseen);
}

TEST(UnknownValve, IsStoppedSoonWhereTheSensorFreezesWhileTheRodExplores) {
  for (const double gain : {0.2, 1.0}) {
    const Measured result = measured(rod_of(gain), unknown_rig(), stuck_from(40'000));
    EXPECT_EQ(result.fault, acquisition::Fault::no_motion) << gain;
    EXPECT_LT(result.way_in, 0.3) << gain;
    EXPECT_LT(result.fastest_in_per_s, 0.4) << gain;
  }
}

TEST(SheetPace, KeepsTheVoltsWithinReachAndTheSinesOutsideOfTheEdge) {
  const ident::SheetPlan plan = config::characterisation_plan(unknown_rig());
  const auto played = [&](const PaceBounds& bounds) {
    SheetPace pace(plan, 0.0);
    pace.bound_by(bounds);
    Eigen::VectorXd volts(plan.table_V.size());
    for (Eigen::Index k = 0; k < volts.size(); ++k) {
      volts[k] = pace.paced_V(static_cast<std::uint32_t>(k), plan.table_V[k]);
    }
    return volts;
  };
  EXPECT_TRUE(played({.edge_V = 0.3, .reach_V = 4.0}).isApprox(plan.table_V)) << "a slow rod";
  const Eigen::VectorXd fast = played({.edge_V = 0.3, .reach_V = 0.6});
  EXPECT_NEAR(fast.cwiseAbs().maxCoeff(), 0.6, 1e-9);
  EXPECT_NEAR(fast.segment(plan.sweep_first, plan.sweep_rows).cwiseAbs().maxCoeff(), 0.6, 1e-3);
  for (const ident::SineSegment& sine : plan.sines) {
    EXPECT_GT(fast.segment(sine.first, sine.rows).cwiseAbs().minCoeff(), 0.3 - 1e-9);
  }
}

/// A rod v = gain (u - edge) seen for so long at a command.
void hold(PredictionMonitor& monitor, double command_V, double speed_in_per_s, double time_s, double& place_in) {
  for (int k = 0; k < static_cast<int>(1000.0 * time_s); ++k) {
    place_in += 0.001 * speed_in_per_s;
    monitor.note(command_V, place_in);
  }
}

TEST(PredictionMonitor, LearnsALineAndTripsOnMotionThatIsMissingOrTooMuch) {
  const auto learnt = [](double& place_in) {
    PredictionMonitor monitor(0.001);
    for (int i = 0; i < 3; ++i) {
      hold(monitor, 0.34, 0.028, 3.0, place_in);
      hold(monitor, 0.50, 0.1, 3.0, place_in);
    }
    return monitor;
  };
  double place_in = 0.0;
  PredictionMonitor missing = learnt(place_in);
  ASSERT_TRUE(missing.line(0).has_value());
  EXPECT_FALSE(missing.line(1).has_value());
  EXPECT_NEAR(missing.line(0)->gain_in_per_V_s, 0.45, 0.02);
  EXPECT_NEAR(missing.line(0)->edge_V, 0.278, 0.01);
  EXPECT_EQ(missing.breach().fault, acquisition::Fault::none);
  hold(missing, 0.5, 0.0, 1.5, place_in);
  EXPECT_EQ(missing.breach().fault, acquisition::Fault::no_motion);
  PredictionMonitor excess = learnt(place_in);
  const FlowLine assumed{.gain_in_per_V_s = 0.45, .edge_V = 0.278};
  excess.stop_learning(assumed, assumed);
  hold(excess, 0.5, 0.2, 5.0, place_in);
  EXPECT_EQ(excess.breach().fault, acquisition::Fault::none);
  hold(excess, 0.5, 0.6, 0.5, place_in);
  EXPECT_EQ(excess.breach().fault, acquisition::Fault::unexplained_motion);
}

}  // namespace
}  // namespace eha::place
