// SPDX-License-Identifier: GPL-3.0-or-later
// The rod to a place, on the simulated rig under the tick with all its limits.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "daemon/place/place_source.hpp"
#include "hal/faults/fault_rig.hpp"
#include "hal/sim/sim_rig.hpp"
#include "tests/unit/place/driven_rod.hpp"
#include "tests/unit/place/long_play.hpp"

namespace eha::place {
namespace {

using acquisition::Fault;
using acquisition::Outcome;
using acquisition::State;

TEST(Place, MovesUpAndDownAndComesToRestWithinTheTolerance) {
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(hal::SimOptions{}, 0.0);
  for (const double target_in : {4.5, 1.0, 1.03}) {
    LongPlay play;
    const double end_in = play.move(*rig, target_in);
    EXPECT_EQ(play.report.outcome, Outcome::completed) << target_in;
    EXPECT_EQ(play.machine.state(), State::idle);
    EXPECT_NEAR(end_in, target_in, kTolerance_in);
    for (const auto& row : play.rows) ASSERT_LT(std::abs(row.applied_V), 5.0);
  }
}

TEST(Place, NeedsNoNumbersOfTheValve) {
  for (const double null_V : {-0.4, 0.4}) {
    hal::SimOptions options;
    options.valve_null_offset_V = null_V;
    options.valve_dead_band_V = 0.3;
    const std::unique_ptr<hal::Rig> rig = hal::open_rig(options, 0.0);
    LongPlay play;
    play.used_limits.following.reset();
    EXPECT_NEAR(play.move(*rig, 3.6), 3.6, kTolerance_in) << null_V;
    EXPECT_EQ(play.report.outcome, Outcome::completed) << null_V;
  }
}

TEST(Place, SeesARodAtRestThroughANoisySensor) {
  for (const double noise_V : {0.003, 0.006}) {
    hal::SimOptions options;
    options.sensor_noise_V = noise_V;
    const std::unique_ptr<hal::Rig> rig = hal::open_rig(options, 0.0);
    LongPlay play;
    EXPECT_NEAR(play.move(*rig, 3.6), 3.6, kTolerance_in + 4.0 * 0.6 * noise_V) << noise_V;
    EXPECT_EQ(play.report.outcome, Outcome::completed) << noise_V;
  }
}

TEST(Place, StopsAtALimitThatTheRodReachesOnTheWay) {
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(hal::SimOptions{}, 0.0);
  LongPlay play;
  play.used_limits.travel_max_in = 4.0;
  const double end_in = play.move(*rig, 4.5);
  EXPECT_EQ(play.report.outcome, Outcome::faulted);
  EXPECT_EQ(play.report.fault.fault, Fault::travel_limit);
  EXPECT_TRUE(play.report.safe_confirmed);
  EXPECT_LT(end_in, 4.0);
}

TEST(Place, BringsARodBackFromBeyondALimitAtPlacingSpeed) {
  for (const double from_in : {5.88, 0.02}) {
    hal::SimOptions options;
    options.initial_displacement_in = from_in;
    const std::unique_ptr<hal::Rig> rig = hal::open_rig(options, 0.0);
    LongPlay play;
    play.begin = Begin::anywhere;
    EXPECT_NEAR(play.move(*rig, 2.95), 2.95, kTolerance_in) << from_in;
    EXPECT_EQ(play.report.outcome, Outcome::completed) << from_in;
    for (std::size_t i = 100; i < play.rows.size(); ++i) {
      const double speed = std::abs(play.rows[i].displacement_in - play.rows[i - 100].displacement_in) / 0.1;
      ASSERT_LT(speed, 0.4) << "at row " << i;
      ASSERT_LT(std::abs(play.rows[i].displacement_in - 2.95), std::abs(from_in - 2.95) + 0.02) << "no further out";
    }
  }
}

TEST(Place, TripsWhereTheRodBeyondALimitMovesOutward) {
  // The valve is plugged the other way round.
  hal::SimOptions options;
  options.initial_displacement_in = 5.77;
  const std::unique_ptr<hal::Rig> plant = hal::open_rig(options, 0.0);
  hal::FaultRig rig(*plant,
                    {{.kind = hal::FaultKind::reversed_sensor, .first_tick = 2, .ticks = hal::InjectedFault::kAlways}},
                    hal::spin_for, options.conversion());
  LongPlay play;
  play.begin = Begin::anywhere;
  play.move(rig, 2.95);
  EXPECT_EQ(play.report.outcome, Outcome::faulted);
  EXPECT_TRUE(play.report.safe_confirmed);
}

TEST(Place, SaysThatTheRodDoesNotMove) {
  hal::SimOptions options;
  options.valve_dead_band_V = 4.9;
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(options, 0.0);
  LongPlay play;
  // The following check would find it first.
  play.used_limits.following->limit_in = 1e6;
  play.used_limits.frozen_sensor_s = 0.0;
  play.move(*rig, 3.5, 5.0);
  EXPECT_EQ(play.report.outcome, Outcome::faulted);
  EXPECT_EQ(play.report.fault.fault, Fault::no_motion);
  EXPECT_LT(play.report.fault.at_ns, 3'000'000'000) << "and not at the time-out only";
}

TEST(Place, SaysThatItWasStillOnItsWayAtTheTimeOut) {
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(hal::SimOptions{}, 0.0);
  LongPlay play;
  play.move(*rig, 5.0, 4.0);
  EXPECT_EQ(play.report.fault.fault, Fault::not_in_place);
  EXPECT_GT(play.report.fault.value, 0.5) << "what was left of the way";
}

TEST(Place, StopsWhenTheSensorIsLostOnTheWay) {
  using hal::FaultKind;
  const hal::Conversion conversion = hal::SimOptions{}.conversion();
  const auto lost = [&](hal::InjectedFault fault) {
    const std::unique_ptr<hal::Rig> plant = hal::open_rig(hal::SimOptions{}, 0.0);
    fault.first_tick = 2000;
    fault.ticks = hal::InjectedFault::kAlways;
    LongPlay play;
    hal::FaultRig rig(*plant, {fault}, hal::spin_for, conversion);
    play.move(rig, 3.95);
    EXPECT_EQ(play.report.outcome, Outcome::faulted);
    EXPECT_TRUE(play.report.safe_confirmed || fault.kind == FaultKind::removed);
    // The rod itself, by a sensor that works.
    hal::RigReading rests;
    plant->read(static_cast<std::int64_t>(play.rows.size()) * 1'000'000, rests);
    EXPECT_LT(rests.displacement_in, 3.95) << "it has been stopped on its way";
    return play.report.fault.fault;
  };
  EXPECT_EQ(lost({.kind = FaultKind::stuck_sensor, .noise_LSB = 3.0}), Fault::no_motion);
  EXPECT_EQ(lost({.kind = FaultKind::stuck_sensor}), Fault::no_motion);
  EXPECT_EQ(lost({.kind = FaultKind::rail}), Fault::feedback_rail);
  EXPECT_EQ(lost({.kind = FaultKind::removed}), Fault::device_removed);
  EXPECT_EQ(lost({.kind = FaultKind::spike, .amount = 3.0}), Fault::velocity_limit) << "faster than any rod";
}

TEST(Place, FindsASlopeThatHalvesOnItsWay) {
  const hal::Conversion conversion = hal::SimOptions{}.conversion();
  for (const double flow : {1.2, 10.0}) {
    const auto tripped = [&](hal::InjectedFault fault) {
      hal::SimOptions options;
      options.valve_rated_flow_L_per_min = flow;
      options.initial_displacement_in = 1.0;
      const std::unique_ptr<hal::Rig> plant = hal::open_rig(options, 0.0);
      fault.first_tick = 2500;
      fault.ticks = hal::InjectedFault::kAlways;
      LongPlay play;
      play.used_limits.following->gain_positive_in_per_V_s *= flow / 1.2;
      play.used_limits.following->gain_negative_in_per_V_s *= flow / 1.2;
      hal::FaultRig rig(*plant, {fault}, hal::spin_for, conversion);
      play.move(rig, 5.0);
      hal::RigReading rests;
      plant->read(static_cast<std::int64_t>(play.rows.size()) * 1'000'000, rests);
      EXPECT_LT(rests.displacement_in - play.rows[2500].displacement_in, 0.5) << flow;
      EXPECT_LT(play.report.fault.at_ns, 4'000'000'000) << flow;
      return play.report.fault.fault;
    };
    EXPECT_EQ(tripped({.kind = hal::FaultKind::scaled_sensor, .amount = 0.5}), Fault::wrong_speed) << flow;
  }
}

/// Viscous friction lets a rod be faster at few volts than the gain says, which is measured at many: half of its speed
/// is then not far from the least speed expected.
TEST(Place, FindsASlopeThatHalvesOfRodsWithMuchFriction) {
  for (unsigned run = 0; run < 12; ++run) {
    test::Random random(run);
    hal::SimOptions plant = test::random_plant(random);
    constexpr double kOfTheSample = 4.5;
    const hal::SimOptions sample;
    plant.coulomb_friction_N = kOfTheSample * sample.coulomb_friction_N;
    plant.static_friction_N = kOfTheSample * sample.static_friction_N;
    plant.viscous_friction_N_s_per_mm = kOfTheSample * sample.viscous_friction_N_s_per_mm;
    plant.friction_regularisation_mm_per_s = kOfTheSample * sample.friction_regularisation_mm_per_s;
    plant.initial_displacement_in = 1.3;
    const config::RigConfig rig = test::rig_with(test::commissioned(plant, random));
    PlaceSource source(PlaceController(rig.limits, test::kTick_s, 4.7), 60'000);
    const test::Driven did = test::driven(plant, rig, source,
                                          hal::InjectedFault{.kind = hal::FaultKind::scaled_sensor,
                                                             .first_tick = 2500,
                                                             .ticks = hal::InjectedFault::kAlways,
                                                             .amount = 0.5});
    EXPECT_EQ(did.fault, Fault::wrong_speed) << run;
    EXPECT_LT(did.lost_in, 0.5) << run;
    EXPECT_FALSE(did.met_end_stop) << run;
  }
}

TEST(Place, FindsASensorThatLagsByTwoSeconds) {
  const hal::Conversion conversion = hal::SimOptions{}.conversion();
  for (const double flow : {1.2, 10.0}) {
    hal::SimOptions options;
    options.valve_rated_flow_L_per_min = flow;
    options.initial_displacement_in = 1.0;
    const std::unique_ptr<hal::Rig> plant = hal::open_rig(options, 0.0);
    LongPlay play;
    play.used_limits.following->gain_positive_in_per_V_s *= flow / 1.2;
    play.used_limits.following->gain_negative_in_per_V_s *= flow / 1.2;
    hal::FaultRig rig(*plant,
                      {{.kind = hal::FaultKind::lagging_sensor,
                        .first_tick = 100,
                        .ticks = hal::InjectedFault::kAlways,
                        .amount = 2000.0}},
                      hal::spin_for, conversion);
    play.move(rig, 5.0);
    hal::RigReading rests;
    plant->read(static_cast<std::int64_t>(play.rows.size()) * 1'000'000, rests);
    std::printf("lag of 2 s: %s after %.2f s and %.3f in\n", std::string(to_text(play.report.fault.fault)).c_str(),
                static_cast<double>(play.report.fault.at_ns) * 1e-9, rests.displacement_in - 1.0);
    EXPECT_EQ(play.report.outcome, Outcome::faulted) << flow;
    EXPECT_LT(rests.displacement_in - 1.0, 1.0) << flow;
  }
}

TEST(Place, RampsOutOnAStop) {
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(hal::SimOptions{}, 0.0);
  LongPlay play;
  play.stop.request();
  play.move(*rig, 5.0);
  EXPECT_EQ(play.report.outcome, Outcome::interrupted);
  EXPECT_TRUE(play.report.safe_confirmed);
}

TEST(StartingSource, PlaysTheExperimentFromItsPlaceOn) {
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(hal::SimOptions{}, 0.0);
  LongPlay play;
  play.limits = play.used_limits;
  std::vector<double> table_V = acquisition::cosine(1000);
  for (double& u : table_V) u *= 0.5;  // within the slew limit
  StartingSource source(PlaceController(play.limits, 0.001, 2.0), play.limits, 0.001,
                        std::make_unique<acquisition::TableSource>(table_V, 1));
  play.play_on(*rig, source);
  EXPECT_EQ(play.report.outcome, Outcome::completed);
  EXPECT_EQ(play.count(State::running), 1000U);
  const std::size_t first = play.first(State::running);
  EXPECT_NEAR(play.rows[first].displacement_in, 2.0, 0.06) << "the ramp to row 0 moves it a little";
  for (std::size_t k = 0; k < table_V.size(); ++k) {
    ASSERT_DOUBLE_EQ(play.rows[first + k].requested_V, table_V[k]);
    ASSERT_EQ(play.rows[first + k].flags & acquisition::kSlewLimited, 0) << "row " << k;
  }
}

TEST(StartingSource, WaitsForThePressureWhereTheRodStandsInItsPlace) {
  // Missing motion does not count before, and a dead sensor would not show.
  constexpr double kDelay_s = 2.0;
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(hal::SimOptions{}, 0.0);
  LongPlay play;
  play.used_limits.following->pressure_delay_s = kDelay_s;
  play.limits = play.used_limits;
  const std::vector<double> table_V(100, 0.0);
  StartingSource source(PlaceController(play.limits, 0.001, 2.95), play.limits, 0.001,
                        std::make_unique<acquisition::TableSource>(table_V, 1));
  play.play_on(*rig, source);
  EXPECT_EQ(play.report.outcome, Outcome::completed);
  EXPECT_GE(0.001 * static_cast<double>(play.first(State::running)), kDelay_s);
}

TEST(StartingSource, PlaysNothingWhenThePlaceIsNotReached) {
  hal::SimOptions options;
  options.valve_dead_band_V = 4.9;
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(options, 0.0);
  LongPlay play;
  play.used_limits.following->limit_in = 1e6;
  play.used_limits.frozen_sensor_s = 0.0;
  play.limits = play.used_limits;
  const std::vector<double> table_V = acquisition::cosine(100);
  StartingSource source(PlaceController(play.limits, 0.001, 3.0), play.limits, 0.001,
                        std::make_unique<acquisition::TableSource>(table_V, 1));
  play.play_on(*rig, source);
  EXPECT_EQ(play.report.fault.fault, Fault::no_motion);
  EXPECT_EQ(play.count(State::running), 0U);
}

}  // namespace
}  // namespace eha::place
