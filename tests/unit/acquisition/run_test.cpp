// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "core/error.hpp"
#include "daemon/acquisition/loop.hpp"
#include "daemon/acquisition/tick_engine.hpp"
#include "hal/faults/fault_rig.hpp"
#include "tests/unit/acquisition/fake_rig.hpp"
#include "tests/unit/acquisition/play.hpp"

namespace eha::acquisition {
namespace {

TEST(Run, GoesThroughItsStatesInOrderAndRecordsEveryTick) {
  FakeRig rig;
  Play play;
  play.on(rig);
  EXPECT_EQ(play.report.outcome, Outcome::completed);
  EXPECT_EQ(play.report.final_state, State::idle);
  EXPECT_EQ(play.machine.state(), State::idle);
  EXPECT_EQ(describe(play.report), "");
  EXPECT_EQ(exit_code(play.report), ExitCode::ok);
  State last = State::armed;
  for (std::size_t k = 0; k < play.rows.size(); ++k) {
    EXPECT_EQ(play.rows[k].sequence, k);
    EXPECT_EQ(play.rows[k].scheduled_ns, static_cast<std::int64_t>(k) * 1'000'000);
    EXPECT_GE(play.rows[k].state, last);
    last = play.rows[k].state;
  }
  EXPECT_EQ(play.count(State::armed), 100u);
  EXPECT_EQ(play.count(State::ramp_in), 20u);  // 2 V at 100 V/s
  EXPECT_EQ(play.count(State::running), 500u);
  EXPECT_EQ(play.report.counters.experiment_rows, 500u);
  EXPECT_EQ(play.report.counters.ticks, play.rows.size());
}

TEST(Run, AppliesTheFirstVoltageOfTheTableInItsFirstRunningRow) {
  FakeRig rig;
  Play play;
  play.on(rig);
  const std::size_t first = play.first(State::running);
  for (std::size_t k = 0; k < play.table_V.size(); ++k) {
    ASSERT_DOUBLE_EQ(play.rows[first + k].applied_V, play.table_V[k]) << "row " << k;
    ASSERT_DOUBLE_EQ(play.rows[first + k].requested_V, play.table_V[k]);
    ASSERT_EQ(play.rows[first + k].repetition, 1);
  }
}

TEST(Run, SamplesBeforeItAppliesAndHoldsToTheNextTick) {
  FakeRig rig;
  Play play;
  play.on(rig);
  for (std::size_t k = play.first(State::ramp_in); k + 1 < play.rows.size(); ++k) {
    const double moved_in = play.rows[k + 1].displacement_in - play.rows[k].displacement_in;
    ASSERT_NEAR(moved_in, play.rows[k].applied_V * 0.001, 1e-12) << "row " << k;
  }
}

TEST(Run, RampsInAndOutUnderTheSlewLimit) {
  FakeRig rig;
  Play play;
  play.on(rig);
  double last_V = 0.0;
  for (const TickRecord& row : play.rows) {
    ASSERT_LE(std::abs(row.applied_V - last_V), 0.1 + 1e-12) << "row " << row.sequence;
    last_V = row.applied_V;
  }
  EXPECT_DOUBLE_EQ(play.rows.back().applied_V, 0.0);
  EXPECT_TRUE(rig.is_safe());
}

TEST(Run, SwitchesTheEnableLineOnlyAfterTheSafeVoltageWasWrittenAndOffAtTheEnd) {
  FakeRig rig;
  Play play;
  play.on(rig);
  ASSERT_GE(rig.writes().size(), 2u);
  EXPECT_DOUBLE_EQ(rig.writes()[0].voltage_V, 0.0);
  EXPECT_FALSE(rig.writes()[0].enabled);
  EXPECT_TRUE(rig.writes()[1].enabled);
  EXPECT_FALSE(rig.writes().back().enabled);
  EXPECT_TRUE(play.report.safe_confirmed);
}

TEST(Run, PlaysRepetitionsBackToBackAndMarksThem) {
  FakeRig rig;
  Play play;
  play.repetitions = 3;
  play.on(rig);
  EXPECT_EQ(play.count(State::running), 1500u);
  const std::size_t first = play.first(State::running);
  for (std::size_t k = 0; k < 1500; ++k) {
    ASSERT_EQ(play.rows[first + k].repetition, k / 500 + 1);
    ASSERT_DOUBLE_EQ(play.rows[first + k].requested_V, play.table_V[k % 500]);
  }
}

TEST(Run, KeepsTheExcitationOnTheGridAcrossSkippedTicks) {
  FakeRig fake;
  Play play;
  hal::FaultRig rig(fake, {{.kind = hal::FaultKind::slow_read, .first_tick = 300, .ticks = 1, .amount = 0.0032}},
                    [&](std::int64_t duration_ns) { play.clock.advance(duration_ns); });
  play.on(rig);
  EXPECT_EQ(play.report.outcome, Outcome::completed);
  EXPECT_EQ(play.report.counters.skipped, 2u);
  EXPECT_EQ(play.report.counters.skipped_rows, 2u);
  EXPECT_EQ(play.count(State::running), 500u);
  const std::size_t first = play.first(State::running);
  for (std::size_t k = 0; k < 500; ++k) {
    const TickRecord& row = play.rows[first + k];
    ASSERT_EQ(row.sequence, play.rows[first].sequence + k);
    ASSERT_DOUBLE_EQ(row.requested_V, play.table_V[k]);
    if ((row.flags & kSkipped) != 0) {
      EXPECT_TRUE(std::isnan(row.displacement_in));
      EXPECT_DOUBLE_EQ(row.applied_V, play.rows[first + k - 1].applied_V);
    }
  }
  EXPECT_EQ(play.report.latency.maximum_ns(), 2'200'000);
  EXPECT_EQ(play.report.latency.maximum_at_ns(), 303'000'000);
}

TEST(Run, RampsInFullyWhenTheFirstWriteOfTheRampTimesOut) {
  FakeRig healthy;
  Play undisturbed;
  undisturbed.on(healthy);
  const auto first_of_ramp = static_cast<std::int64_t>(undisturbed.first(State::ramp_in));
  FakeRig fake;
  Play play;
  hal::FaultRig rig(fake, {{.kind = hal::FaultKind::command_timed_out, .first_tick = first_of_ramp, .ticks = 1}});
  play.on(rig);
  ASSERT_EQ(play.report.outcome, Outcome::completed) << describe(play.report);
  const std::size_t first = play.first(State::running);
  EXPECT_DOUBLE_EQ(play.rows[first].applied_V, play.table_V[0]);
  EXPECT_EQ(play.count(State::ramp_in), undisturbed.count(State::ramp_in) + 1);
}

TEST(Run, CountsEverySkippedTickOfALongStall) {
  FakeRig fake;
  Play play;
  hal::FaultRig rig(fake, {{.kind = hal::FaultKind::slow_read, .first_tick = 300, .ticks = 1, .amount = 0.4005}},
                    [&](std::int64_t duration_ns) { play.clock.advance(duration_ns); });
  play.on(rig);
  EXPECT_EQ(play.report.outcome, Outcome::deadline);
  EXPECT_EQ(play.report.counters.skipped, 399u);
  // More ticks than the loop records as rows; they still count as rows of the experiment.
  EXPECT_LT(play.count(State::running), play.table_V.size());
  EXPECT_EQ(play.report.counters.experiment_rows, play.table_V.size());
}

TEST(Run, WritesNothingOnceAFatalSignalHandlerHasTakenTheOutputsInTheMiddleOfATick) {
  FakeRig fake;
  Play play;
  std::size_t writes_before = 0;
  hal::FaultRig rig(fake, {{.kind = hal::FaultKind::slow_read, .first_tick = 300, .ticks = 1, .amount = 0.0002}},
                    [&](std::int64_t duration_ns) {
                      play.clock.advance(duration_ns);
                      play.stop.take_over_outputs();
                      writes_before = fake.writes().size();
                    });
  play.on(rig);
  ASSERT_GT(writes_before, 0u);
  EXPECT_EQ(fake.writes().size(), writes_before);
  EXPECT_EQ(play.report.outcome, Outcome::interrupted);
}

TEST(StopRequest, ForARampOutIsNeverTheSecondOne) {
  StopRequest stop;
  stop.request_ramp_out();
  stop.request_ramp_out();
  EXPECT_EQ(stop.count(), 1);
  stop.request();
  stop.request_ramp_out();
  EXPECT_EQ(stop.count(), 2);
}

TEST(Run, RampsOutOnAStopRequest) {
  FakeRig rig;
  Play play;
  play.stop.request();
  play.on(rig);
  EXPECT_EQ(play.report.outcome, Outcome::interrupted);
  EXPECT_EQ(exit_code(play.report), ExitCode::interrupted);
  EXPECT_EQ(play.report.final_state, State::idle);
  EXPECT_EQ(play.count(State::running), 0u);
  EXPECT_TRUE(rig.is_safe());
}

/// Calls something before one tick, as another thread or a signal would in between.
class InterruptedClock final : public Clock {
 public:
  InterruptedClock(std::vector<std::int64_t> ticks, std::function<void()> action, bool is_virtual = true)
      : ticks_(std::move(ticks)), action_(std::move(action)), is_virtual_(is_virtual) {}
  [[nodiscard]] std::int64_t now_ns() noexcept override { return now_ns_; }
  void sleep_until(std::int64_t deadline_ns) noexcept override {
    for (const std::int64_t tick : ticks_) {
      if (tick == calls_) action_();
    }
    ++calls_;
    if (deadline_ns > now_ns_) now_ns_ = deadline_ns;
  }
  [[nodiscard]] bool is_virtual() const noexcept override { return is_virtual_; }

 private:
  std::vector<std::int64_t> ticks_;
  std::function<void()> action_;
  bool is_virtual_;
  std::int64_t now_ns_ = 0;
  std::int64_t calls_ = 0;
};

/// The loop in this thread, on any clock.
void loop_on(Play& play, hal::Rig& rig, Clock& clock) {
  play.machine.reset();
  play.machine.arm();
  TableSource source(play.table_V, play.repetitions);
  TickEngine engine(rig, play.machine, source, play.limits, play.realtime, LatePolicy::abort, clock);
  Loop(engine, play.machine, 1'000'000, {clock, *play.queue, play.stop, play.board}, play.report).run();
  play.drain();
}

TEST(Run, RampsOutFromTheMiddleOfARunAndIsSafeAtOnceOnASecondStop) {
  FakeRig once;
  Play play;
  InterruptedClock clock({300}, [&] { play.stop.request(); });
  loop_on(play, once, clock);
  EXPECT_EQ(play.report.outcome, Outcome::interrupted);
  EXPECT_EQ(play.report.final_state, State::idle);
  EXPECT_EQ(play.rows[300].state, State::ramp_out);
  EXPECT_TRUE(once.is_safe());

  FakeRig twice;
  Play hurried;
  InterruptedClock impatient({300, 305}, [&] { hurried.stop.request(); });
  loop_on(hurried, twice, impatient);
  EXPECT_EQ(hurried.report.outcome, Outcome::interrupted);
  EXPECT_EQ(hurried.report.final_state, State::faulted);
  EXPECT_EQ(hurried.rows.back().sequence, 305u);
  EXPECT_EQ(hurried.rows.back().state, State::safe_stop);
  EXPECT_DOUBLE_EQ(hurried.rows.back().applied_V, 0.0);
  EXPECT_TRUE(twice.is_safe());
}

TEST(Run, WritesNothingAnyMoreOnceASignalHandlerTookTheOutputs) {
  FakeRig rig;
  Play play;
  std::size_t writes = 0;
  InterruptedClock clock({300}, [&] {
    play.stop.take_over_outputs();
    writes = rig.writes().size();
  });
  loop_on(play, rig, clock);
  EXPECT_EQ(rig.writes().size(), writes);
  EXPECT_EQ(play.rows.back().sequence, 300u);
  EXPECT_FALSE(play.report.safe_confirmed);
}

TEST(Run, SurvivesAWriterThatStandsStillForFiveSeconds) {
  FakeRig rig;
  Play play;
  play.table_V = cosine(10'000);
  const auto drain = [&] { play.drain(); };
  InterruptedClock clock({5000, 10'000}, drain, false);
  loop_on(play, rig, clock);
  EXPECT_EQ(play.report.outcome, Outcome::completed);
  EXPECT_EQ(play.report.counters.dropped, 0u);
  EXPECT_EQ(play.report.counters.queue_peak, 5000u);
  EXPECT_EQ(play.count(State::running), 10'000u);
}

TEST(Run, RampsOutWithoutLosingARecordWhenTheWriterDoesNotComeBack) {
  FakeRig rig;
  Play play;
  play.table_V = cosine(20'000);
  InterruptedClock clock(
      {}, [] {}, false);
  loop_on(play, rig, clock);
  EXPECT_EQ(play.report.outcome, Outcome::write_failed);
  EXPECT_EQ(exit_code(play.report), ExitCode::io);
  EXPECT_EQ(play.report.final_state, State::idle);
  EXPECT_EQ(play.report.counters.dropped, 0u);
  EXPECT_EQ(play.rows.size(), play.report.counters.ticks);
  EXPECT_EQ(play.rows[RecordQueue::kNearlyFull].state, State::ramp_out);
  EXPECT_TRUE(rig.is_safe());
}

TEST(Run, RampsOutWhenTheWriterReportsAFailure) {
  FakeRig rig;
  Play play;
  InterruptedClock clock({300}, [&] { play.queue->report_writer_failure(); });
  loop_on(play, rig, clock);
  EXPECT_EQ(play.report.outcome, Outcome::write_failed);
  EXPECT_EQ(play.rows[300].state, State::ramp_out);
  EXPECT_TRUE(rig.is_safe());
}

TEST(Run, RefusesWhatContradictsTheRigBeforeAnythingIsWritten) {
  const auto refused = [](const auto& spoil) {
    FakeRig rig;
    Play play;
    spoil(play);
    EXPECT_THROW(play.on(rig), ConfigError);
    EXPECT_TRUE(rig.writes().empty());
    EXPECT_TRUE(play.rows.empty());
  };
  refused([](Play& play) { play.table_V.clear(); });
  refused([](Play& play) { play.table_V[17] = std::numeric_limits<double>::quiet_NaN(); });
  refused([](Play& play) { play.repetitions = 0; });
  refused([](Play& play) { play.limits.command_max_V = 11.0; });
  refused([](Play& play) { play.limits.safe_V = 6.0; });
  refused([](Play& play) { play.limits.slew_V_per_s = 0.0; });
  refused([](Play& play) { play.limits.travel_max_in = 0.1; });
  refused([](Play& play) { play.limits.stopping_deceleration_in_per_s2 = 0.0; });
  refused([](Play& play) { play.limits.velocity_limit_in_per_s = 0.0; });
  refused([](Play& play) { play.realtime.sample_period_s = 0.0; });
}

TEST(Run, RefusesARigThatIsNotArmedAndVirtualTimeOnOneThatMoves) {
  FakeRig rig;
  Play play;
  TableSource source(play.table_V, 1);
  EXPECT_THROW(static_cast<void>(run(rig, play.machine, source, play.limits, play.realtime, NonRealtime::refuse,
                                     play.clock, *play.queue, play.stop, play.board)),
               ConfigError);
  FakeRig real(true);
  EXPECT_THROW(play.on(real), ConfigError);
  EXPECT_TRUE(real.writes().empty());
}

TEST(Run, KeepsRealTimeOnTheMonotonicClock) {
  FakeRig rig;
  Play play;
  play.table_V = cosine(100);
  MonotonicClock clock;
  play.machine.reset();
  play.machine.arm();
  const std::int64_t begun_ns = clock.now_ns();
  TableSource source(play.table_V, 1);
  play.report = run(rig, play.machine, source, play.limits, play.realtime, NonRealtime::allow, clock, *play.queue,
                    play.stop, play.board);
  const std::int64_t duration_ns = clock.now_ns() - begun_ns;
  play.drain();
  // Under any load, no tick starts before its time.
  EXPECT_GE(duration_ns, play.rows.back().scheduled_ns);
  for (const TickRecord& row : play.rows) EXPECT_GE(row.lateness_ns, 0);
  const RealtimeFacts& facts = play.report.realtime;
  EXPECT_TRUE((facts.fifo && facts.memory_locked && facts.c_states_held) || !facts.refused.empty());
}

TEST(Margins, AreFlaggedReportedAndSaidWhenARunComesNearALimit) {
  // From 2.95 in at 1 in/(V s): 2 V cos at 2 Hz has an amplitude of 0.16 in and 2 in/s; then an offset carries it out.
  FakeRig rig;
  Play quiet;
  quiet.on(rig);
  EXPECT_TRUE(warnings(quiet.report).empty());
  EXPECT_LT(quiet.report.travel.share, kWarningShare);
  EXPECT_NEAR(quiet.report.velocity.share, 2.0 / 20.0, 0.02);
  for (const TickRecord& row : quiet.rows) EXPECT_EQ(row.flags & (kNearTravel | kNearVelocity), 0);

  FakeRig far;
  Play play;
  play.limits.travel_max_in = quiet.rows.back().displacement_in + 0.4;
  play.limits.travel_min_in = -play.limits.travel_max_in;
  play.limits.velocity_limit_in_per_s = 2.2;
  play.on(far);
  EXPECT_EQ(play.report.outcome, Outcome::completed) << describe(play.report);
  EXPECT_GT(play.report.velocity.share, kWarningShare);
  EXPECT_LT(play.report.velocity.share, 1.0);
  bool flagged = false;
  for (const TickRecord& row : play.rows) flagged = flagged || (row.flags & kNearVelocity) != 0;
  EXPECT_TRUE(flagged);
  const std::vector<std::string> said = warnings(play.report);
  ASSERT_FALSE(said.empty());
  EXPECT_NE(said.back().find("% of the velocity limit at "), std::string::npos) << said.back();
  for (const std::string& sentence : warnings(play.report, RunKind::placing)) {
    EXPECT_EQ(sentence.find(" limit"), std::string::npos) << "of a placing it is not said: " << sentence;
  }
  EXPECT_EQ(describe(play.report), "") << "a run near a limit has completed all the same";
}

}  // namespace
}  // namespace eha::acquisition
