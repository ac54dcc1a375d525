// SPDX-License-Identifier: GPL-3.0-or-later
// Sources that answer to the reading, and limits that hold for what they request.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "daemon/acquisition/run.hpp"
#include "hal/faults/fault_rig.hpp"
#include "tests/unit/acquisition/fake_rig.hpp"
#include "tests/unit/acquisition/play.hpp"

namespace eha::acquisition {
namespace {

/// Drives the rod towards a position, in proportion to the distance left.
class Approach final : public CommandSource {
 public:
  Approach(std::uint32_t rows, double target_in, double gain_V_per_in)
      : rows_(rows), target_in_(target_in), gain_V_per_in_(gain_V_per_in) {}
  [[nodiscard]] std::uint32_t rows() const noexcept override { return rows_; }
  [[nodiscard]] std::uint32_t rows_per_repetition() const noexcept override { return rows_; }
  [[nodiscard]] double voltage_V(std::uint32_t, const hal::RigReading& last) noexcept override {
    return gain_V_per_in_ * (target_in_ - last.displacement_in);
  }

 private:
  std::uint32_t rows_;
  double target_in_;
  double gain_V_per_in_;
};

/// Waits for so many calls before its rows.
class Waiting final : public CommandSource {
 public:
  explicit Waiting(int calls) : left_(calls) {}
  [[nodiscard]] Stage stage() const noexcept override { return left_ > 0 ? Stage::preparing : Stage::playing; }
  [[nodiscard]] std::uint32_t rows() const noexcept override { return 100; }
  [[nodiscard]] std::uint32_t rows_per_repetition() const noexcept override { return 100; }
  [[nodiscard]] double voltage_V(std::uint32_t, const hal::RigReading&) noexcept override {
    --left_;
    return 0.0;
  }

 private:
  int left_;
};

TEST(Run, LetsASourceCountItsTimeAlsoWhereTicksNeverRan) {
  const auto ticks_of = [](double stall_s) {
    FakeRig fake;
    Play play;
    hal::FaultRig rig(fake, {{.kind = hal::FaultKind::slow_read, .first_tick = 120, .ticks = 1, .amount = stall_s}},
                      [&](std::int64_t duration_ns) { play.clock.advance(duration_ns); });
    Waiting waiting(300);
    play.on(rig, waiting);
    EXPECT_EQ(play.report.outcome, Outcome::completed) << describe(play.report);
    EXPECT_EQ(play.report.counters.skipped, stall_s > 0.001 ? 3U : 0U);
    return play.count(State::ramp_in);
  };
  EXPECT_EQ(ticks_of(0.0042), ticks_of(0.0));
}

TEST(Run, LetsASourceAnswerToTheLastReading) {
  FakeRig rig;
  Play play;
  Approach approach(3000, 3.5, 5.0);
  play.on(rig, approach);
  EXPECT_EQ(play.report.outcome, Outcome::completed) << describe(play.report);
  EXPECT_EQ(play.report.counters.experiment_rows, 3000U);
  // A time constant of 1 / (5 V/in * 1 in/s/V) = 0.2 s, after 3 s.
  const auto last_running = std::find_if(play.rows.rbegin(), play.rows.rend(),
                                         [](const TickRecord& row) { return row.state == State::running; });
  ASSERT_NE(last_running, play.rows.rend());
  EXPECT_NEAR(last_running->displacement_in, 3.5, 1e-4);
}

TEST(Run, ClampsAndSlowsWhatASourceRequests) {
  FakeRig rig;
  rig.gain_in_per_s_V = 0.2;  // slow enough to stay within the travel, and to be seen to follow
  Play play;
  Approach approach(500, 1000.0, 1.0);  // requests 997 V
  play.on(rig, approach);
  const double largest_step_V = play.limits.slew_V_per_s * play.realtime.sample_period_s;
  for (std::size_t k = 1; k < rig.writes().size(); ++k) {
    EXPECT_LE(rig.writes()[k].voltage_V, play.limits.command_max_V);
    EXPECT_LE(rig.writes()[k].voltage_V - rig.writes()[k - 1].voltage_V, largest_step_V + 1e-12);
  }
  EXPECT_EQ(play.report.counters.clamped, 500U);
}

TEST(Run, IsSafeWhenASourceRequestsNoVoltage) {
  FakeRig rig;
  Play play;
  Approach approach(500, std::numeric_limits<double>::quiet_NaN(), 1.0);
  play.on(rig, approach);
  EXPECT_EQ(play.report.fault.fault, Fault::command_not_finite);
  EXPECT_TRUE(rig.is_safe());
}

}  // namespace
}  // namespace eha::acquisition
