// SPDX-License-Identifier: GPL-3.0-or-later
// Every fault in each phase of a run: the documented end, safe outputs, a complete record, the right exit code.
#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "hal/faults/fault_rig.hpp"
#include "tests/unit/acquisition/fake_rig.hpp"
#include "tests/unit/acquisition/play.hpp"

namespace eha::acquisition {
namespace {

using hal::FaultKind;

enum class Phase { ramp, run, last_tick };

/// An injected fault and the expected result.
struct Case {
  std::string name;
  std::vector<hal::InjectedFault> faults;  ///< first_tick is filled in from the phase
  Outcome outcome = Outcome::faulted;
  Fault fault = Fault::none;
  ExitCode exit = ExitCode::safety_trip;
  bool safe_confirmed = true;
};

/// Names the case in test listings.
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

std::vector<Case> cases() {
  constexpr std::int64_t kAlways = hal::InjectedFault::kAlways;
  const auto fault = [](FaultKind kind, std::int64_t ticks, double amount = 0.0) {
    return hal::InjectedFault{kind, 0, ticks, amount};
  };
  return {
      {"OneReadTimeOut", {fault(FaultKind::read_timed_out, 1)}, Outcome::completed, Fault::none, ExitCode::ok},
      {"TwoReadTimeOuts", {fault(FaultKind::read_timed_out, 2)}, Outcome::completed, Fault::none, ExitCode::ok},
      {"ThreeReadTimeOuts",
       {fault(FaultKind::read_timed_out, 3)},
       Outcome::faulted,
       Fault::repeated_timeouts,
       ExitCode::device_unavailable},
      {"OneCommandTimeOut", {fault(FaultKind::command_timed_out, 1)}, Outcome::completed, Fault::none, ExitCode::ok},
      {"ThreeCommandTimeOuts",
       {fault(FaultKind::command_timed_out, 3)},
       Outcome::faulted,
       Fault::repeated_timeouts,
       ExitCode::device_unavailable},
      {"SlowReadTimeOut",
       {fault(FaultKind::read_timed_out, 1), fault(FaultKind::slow_read, 1, 0.0015)},
       Outcome::faulted,
       Fault::call_overran,
       ExitCode::device_unavailable},
      {"SlowCommandTimeOut",
       {fault(FaultKind::command_timed_out, 1), fault(FaultKind::slow_command, 1, 0.0015)},
       Outcome::faulted,
       Fault::call_overran,
       ExitCode::device_unavailable},
      {"ReadError",
       {fault(FaultKind::read_io_error, 1)},
       Outcome::faulted,
       Fault::read_failed,
       ExitCode::device_unavailable},
      {"CommandError",
       {fault(FaultKind::command_io_error, 1)},
       Outcome::faulted,
       Fault::command_failed,
       ExitCode::device_unavailable},
      {"CommandErrorForEver",
       {fault(FaultKind::command_io_error, kAlways)},
       Outcome::faulted,
       Fault::command_failed,
       ExitCode::device_unavailable},
      {"Removed",
       {fault(FaultKind::removed, 1)},
       Outcome::faulted,
       Fault::device_removed,
       ExitCode::device_unavailable,
       false},
      {"NotFinite", {fault(FaultKind::not_finite, 1)}, Outcome::faulted, Fault::feedback_not_finite},
      {"Rail", {fault(FaultKind::rail, 1)}, Outcome::faulted, Fault::feedback_rail},
      {"SpikeUp", {fault(FaultKind::spike, 1, 1.5)}, Outcome::faulted, Fault::velocity_limit},
      {"SpikeDown", {fault(FaultKind::spike, 1, -1.5)}, Outcome::faulted, Fault::velocity_limit},
      {"EmergencyStop", {fault(FaultKind::emergency_stop, 1)}, Outcome::faulted, Fault::emergency_stop},
      {"StalledRead",
       {fault(FaultKind::slow_read, 1, 0.0102)},
       Outcome::deadline,
       Fault::consecutive_late,
       ExitCode::deadline},
      {"ShortStall", {fault(FaultKind::slow_read, 1, 0.0022)}, Outcome::completed, Fault::none, ExitCode::ok},
  };
}

/// Where the phases are, from a run without faults.
std::int64_t tick_of(Phase phase) {
  FakeRig rig;
  Play play;
  play.on(rig);
  switch (phase) {
    case Phase::ramp:
      return static_cast<std::int64_t>(play.first(State::ramp_in)) + 5;
    case Phase::run:
      return static_cast<std::int64_t>(play.first(State::running)) + 200;
    case Phase::last_tick:
      return static_cast<std::int64_t>(play.first(State::ramp_out)) - 1;
  }
  return 0;
}

class FaultMatrix : public ::testing::TestWithParam<std::tuple<Case, Phase>> {};

TEST_P(FaultMatrix, EndsAsDocumentedSafeAndWithACompleteRecord) {
  auto [expected, phase] = GetParam();
  const std::int64_t tick = tick_of(phase);
  for (hal::InjectedFault& fault : expected.faults) fault.first_tick = tick;
  FakeRig wire;
  Play play;
  hal::FaultRig rig(wire, expected.faults, [&](std::int64_t duration_ns) { play.clock.advance(duration_ns); });
  play.on(rig);

  EXPECT_EQ(play.report.outcome, expected.outcome) << describe(play.report);
  EXPECT_EQ(play.report.fault.fault, expected.fault) << to_text(play.report.fault.fault);
  EXPECT_EQ(exit_code(play.report), expected.exit);
  const bool completed = expected.outcome == Outcome::completed;
  EXPECT_EQ(play.report.final_state, completed ? State::idle : State::faulted);
  EXPECT_EQ(describe(play.report).empty(), completed);

  // Safe is the last thing on the wire, and nothing but it from the fault on.
  EXPECT_EQ(play.report.safe_confirmed, expected.safe_confirmed);
  if (expected.safe_confirmed) {
    EXPECT_TRUE(wire.is_safe());
    EXPECT_EQ(play.rows.back().applied_V, 0.0);
  }

  // One row a tick without a gap, and the fault is in the rows from its tick on.
  for (std::size_t k = 0; k < play.rows.size(); ++k) ASSERT_EQ(play.rows[k].sequence, k);
  EXPECT_EQ(play.report.counters.ticks + play.report.counters.skipped, play.rows.size());
  const std::size_t faulted_rows = play.count(State::safe_stop);
  if (completed) {
    EXPECT_EQ(play.count(State::running), 500u);
    EXPECT_EQ(faulted_rows, 0u);
  } else {
    EXPECT_EQ(faulted_rows, expected.safe_confirmed ? 1u : 20u);
    EXPECT_EQ(play.rows.back().fault, expected.fault);
    EXPECT_EQ(play.report.fault.at_ns, play.rows[play.first(State::safe_stop)].scheduled_ns);
  }
}

std::string name_of(const ::testing::TestParamInfo<std::tuple<Case, Phase>>& info) {
  const std::vector<std::string> phases = {"InTheRamp", "InTheRun", "InTheLastTick"};
  return std::get<0>(info.param).name + phases[static_cast<std::size_t>(std::get<1>(info.param))];
}

INSTANTIATE_TEST_SUITE_P(EveryFault, FaultMatrix,
                         ::testing::Combine(::testing::ValuesIn(cases()),
                                            ::testing::Values(Phase::ramp, Phase::run, Phase::last_tick)),
                         name_of);

TEST(FaultMatrixFrozenSensor, EndsARunThatDrivesTheValveAndIsNotLookedForInOneThatNoLongerDoes) {
  for (const Phase phase : {Phase::ramp, Phase::run, Phase::last_tick}) {
    FakeRig wire;
    Play play;
    play.table_V.assign(500, 2.0);
    hal::FaultRig rig(wire, {{FaultKind::stuck_sensor, tick_of(phase), hal::InjectedFault::kAlways, 0.0}});
    play.on(rig);
    const bool is_driven = phase != Phase::last_tick;
    EXPECT_EQ(play.report.outcome, is_driven ? Outcome::faulted : Outcome::completed);
    EXPECT_EQ(play.report.fault.fault, is_driven ? Fault::frozen_sensor : Fault::none);
    EXPECT_TRUE(wire.is_safe());
  }
}

TEST(FaultMatrixOutputTimeOut, SwitchesTheHydraulicsOffBeforeTheOutputIsTriedAgain) {
  constexpr double kTimeOut_s = 0.005;  // five ticks
  for (const Phase phase : {Phase::ramp, Phase::run, Phase::last_tick}) {
    FakeRig wire;
    Play play;
    std::vector<bool> enabled_at_call;
    hal::FaultRig rig(wire, {{FaultKind::output_timed_out, tick_of(phase), hal::InjectedFault::kAlways, kTimeOut_s}},
                      [&](std::int64_t duration_ns) {
                        enabled_at_call.push_back(wire.enabled());
                        play.clock.advance(duration_ns);
                      });
    play.on(rig);
    EXPECT_EQ(play.report.fault.fault, Fault::call_overran);
    EXPECT_FALSE(play.report.safe_confirmed);
    EXPECT_FALSE(wire.enabled());
    // The first call is the tick's own; every later one finds the hydraulics off. Each attempt makes one call more.
    ASSERT_EQ(enabled_at_call.size(), 1U + 20U);
    EXPECT_TRUE(enabled_at_call[0]);
    for (std::size_t i = 1; i < enabled_at_call.size(); ++i) EXPECT_FALSE(enabled_at_call[i]) << i;
  }
}

TEST(FaultMatrixContact, StopsARigWhoseContactorDoesNotPullInOrDropsOut) {
  constexpr double kAllowed_s = 0.03;
  for (const Phase phase : {Phase::ramp, Phase::run}) {
    for (const std::int64_t first_tick : {std::int64_t{0}, tick_of(phase)}) {
      FakeRig wire;
      wire.add_contact(kAllowed_s);
      Play play;
      hal::FaultRig rig(wire, {{FaultKind::contact_open, first_tick, hal::InjectedFault::kAlways, 0.0}});
      play.on(rig);
      ASSERT_EQ(play.report.fault.fault, Fault::enable_contact) << "from tick " << first_tick;
      EXPECT_EQ(exit_code(play.report), ExitCode::safety_trip);
      EXPECT_TRUE(play.report.safe_confirmed);
      EXPECT_TRUE(wire.is_safe());
      // One tick more than allowed after the last closed reading, or after the enable line went on in tick 0.
      EXPECT_EQ(play.report.fault.at_ns, (std::max<std::int64_t>(first_tick - 1, 0) + 31) * 1'000'000);
      EXPECT_NE(describe(play.report).find("auxiliary contact"), std::string::npos);
    }
  }
}

TEST(FaultMatrixContact, AllowsTheContactItsTimeToFollow) {
  FakeRig wire;
  wire.add_contact(0.03);
  Play play;
  hal::FaultRig rig(wire, {{FaultKind::contact_open, 0, 30, 0.0}, {FaultKind::contact_open, 200, 30, 0.0}});
  play.on(rig);
  EXPECT_EQ(play.report.outcome, Outcome::completed) << describe(play.report);
}

TEST(FaultMatrixTravel, StopsARodThatRunsTowardsTheEndOfItsTravelInsideIt) {
  for (const double voltage_V : {4.0, -4.0}) {
    FakeRig wire;
    Play play;
    play.table_V.assign(2000, voltage_V);
    play.on(wire);
    EXPECT_EQ(play.report.fault.fault, Fault::travel_limit);
    EXPECT_EQ(exit_code(play.report), ExitCode::safety_trip);
    EXPECT_TRUE(wire.is_safe());
    EXPECT_GT(play.rows.back().displacement_in, play.limits.travel_min_in);
    EXPECT_LT(play.rows.back().displacement_in, play.limits.travel_max_in);
  }
}

TEST(FaultMatrixArmed, NeverEnablesARigWhoseEmergencyStopIsOpenFromTheStart) {
  FakeRig wire;
  Play play;
  hal::FaultRig rig(wire, {{FaultKind::emergency_stop, 0, hal::InjectedFault::kAlways, 0.0}});
  play.on(rig);
  EXPECT_EQ(play.report.fault.fault, Fault::emergency_stop);
  for (const FakeRig::Write& write : wire.writes()) {
    EXPECT_FALSE(write.enabled);
    EXPECT_DOUBLE_EQ(write.voltage_V, 0.0);
  }
}

}  // namespace
}  // namespace eha::acquisition
