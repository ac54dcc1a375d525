// SPDX-License-Identifier: GPL-3.0-or-later
// A suspend of the machine, as the loop sees it by its clock.
#include <gtest/gtest.h>

#include <algorithm>

#include "daemon/acquisition/loop.hpp"
#include "daemon/acquisition/tick_engine.hpp"
#include "tests/unit/acquisition/fake_rig.hpp"
#include "tests/unit/acquisition/play.hpp"

namespace eha::acquisition {
namespace {

constexpr std::int64_t kSuspendTick_ns = 1'000'000;

/// A clock of a machine that was suspended for an hour before the run, and again during a sleep of the loop.
class SuspendedClock final : public Clock {
 public:
  SuspendedClock(std::int64_t at, std::int64_t duration_ns) : at_(at), duration_ns_(duration_ns) {}
  [[nodiscard]] std::int64_t now_ns() noexcept override { return now_ns_; }
  [[nodiscard]] std::int64_t with_suspends_ns() noexcept override { return now_ns_ + suspended_ns_; }
  void sleep_until(std::int64_t deadline_ns) noexcept override {
    if (sleeps_++ == at_) suspended_ns_ += duration_ns_;
    now_ns_ = std::max(now_ns_, deadline_ns);
  }
  [[nodiscard]] bool is_virtual() const noexcept override { return false; }

 private:
  std::int64_t at_;
  std::int64_t duration_ns_;
  std::int64_t now_ns_ = 0;
  std::int64_t suspended_ns_ = 3600 * kNanosecondsPerSecond;
  std::int64_t sleeps_ = 0;
};

class Suspend : public ::testing::Test {
 protected:
  void run(std::int64_t at, std::int64_t duration_ns, int stops = 0) {
    for (int i = 0; i < stops; ++i) play_.stop.request();
    SuspendedClock clock(at, duration_ns);
    play_.machine.arm();
    TableSource source(play_.table_V, play_.repetitions);
    TickEngine engine(rig_, play_.machine, source, play_.limits, play_.realtime, LatePolicy::count, clock);
    const LoopLinks links{clock, *play_.queue, play_.stop, play_.board};
    Loop(engine, play_.machine, kSuspendTick_ns, links, play_.report).run();
    play_.drain();
  }
  void SetUp() override { play_.machine.reset(); }

  FakeRig rig_;
  Play play_;
};

TEST_F(Suspend, IsMadeSafeInTheFirstTickAfterIt) {
  run(300, 11 * kSuspendTick_ns);
  EXPECT_EQ(play_.report.fault.fault, Fault::suspended);
  EXPECT_EQ(play_.report.outcome, Outcome::faulted);
  EXPECT_EQ(play_.report.final_state, State::faulted);
  EXPECT_EQ(exit_code(play_.report), ExitCode::safety_trip);
  EXPECT_EQ(play_.rows.size(), 301U);
  EXPECT_TRUE(rig_.is_safe());
  EXPECT_NE(describe(play_.report).find("suspended at "), std::string::npos);
  EXPECT_NE(describe(play_.report).find("the machine was suspended for 0.011 s"), std::string::npos);
}

TEST_F(Suspend, IsTheFaultAlsoWhereSomebodyStopsTheRunForIt) {
  run(0, 100 * kNanosecondsPerSecond, 2);
  EXPECT_EQ(play_.report.fault.fault, Fault::suspended);
  EXPECT_EQ(play_.rows.size(), 1U);
}

TEST_F(Suspend, IsNoneWhatIsWithinTheReadingOfTwoClocks) {
  run(300, 10 * kSuspendTick_ns);
  EXPECT_EQ(play_.report.outcome, Outcome::completed) << describe(play_.report);
}

TEST(MonotonicClock, CountsTheTimeOfSuspendsBesides) {
  MonotonicClock clock;
  const std::int64_t before_ns = clock.now_ns();
  EXPECT_GE(clock.with_suspends_ns(), before_ns);
}

}  // namespace
}  // namespace eha::acquisition
