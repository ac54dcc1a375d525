// SPDX-License-Identifier: GPL-3.0-or-later
// What the loop shares with the guard.
#include "core/guard_page.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <thread>

#include "daemon/acquisition/loop.hpp"
#include "daemon/acquisition/realtime.hpp"
#include "daemon/acquisition/tick_engine.hpp"
#include "tests/unit/acquisition/fake_rig.hpp"
#include "tests/unit/acquisition/play.hpp"

namespace eha::acquisition {
namespace {

constexpr std::int64_t kPeriod_ns = 1'000'000;

/// A clock that calls itself monotonic, keeps the time of the sleeps, and has the guard act once.
class GuardsClock final : public Clock {
 public:
  /// @param trip_at  sleep after which the guard has acted; -1: never
  GuardsClock(GuardPage& page, std::int64_t trip_at) : page_(page), trip_at_(trip_at) {}
  [[nodiscard]] std::int64_t now_ns() noexcept override { return now_ns_; }
  void sleep_until(std::int64_t deadline_ns) noexcept override {
    driven_ = driven_ && GuardPage::is_driven(page_.drive());
    beats_each_ = beats_each_ && page_.beats() == static_cast<std::uint64_t>(sleeps_);
    if (sleeps_++ == trip_at_) page_.trip(page_.drive());
    now_ns_ = std::max(now_ns_, deadline_ns);
  }
  [[nodiscard]] bool is_virtual() const noexcept override { return false; }
  [[nodiscard]] bool was_driven() const { return driven_; }
  [[nodiscard]] bool beat_once_a_tick() const { return beats_each_; }

 private:
  GuardPage& page_;
  std::int64_t trip_at_;
  std::int64_t now_ns_ = 0;
  std::int64_t sleeps_ = 0;
  bool driven_ = true;
  bool beats_each_ = true;
};

class LoopAndGuard : public ::testing::Test {
 protected:
  void run(Clock& clock) {
    play_.machine.reset();
    play_.machine.arm();
    TableSource source(play_.table_V, play_.repetitions);
    TickEngine engine(rig_, play_.machine, source, play_.limits, play_.realtime, LatePolicy::abort, clock);
    const LoopLinks links{clock, *play_.queue, play_.stop, play_.board, page_.get(), 100 * kPeriod_ns};
    Loop(engine, play_.machine, kPeriod_ns, links, play_.report).run();
    play_.drain();
  }

  FakeRig rig_;
  Play play_;
  std::unique_ptr<GuardPage> page_ = std::make_unique<GuardPage>();
};

TEST_F(LoopAndGuard, ShowsABeatInEachTickOfARunAndNoneOutsideIt) {
  GuardsClock clock(*page_, -1);
  EXPECT_FALSE(GuardPage::is_driven(page_->drive()));
  run(clock);
  EXPECT_EQ(play_.report.outcome, Outcome::completed) << describe(play_.report);
  EXPECT_TRUE(clock.was_driven());
  EXPECT_TRUE(clock.beat_once_a_tick());
  EXPECT_FALSE(GuardPage::is_driven(page_->drive()));
  EXPECT_EQ(page_->stall_limit_ns(), 100 * kPeriod_ns);
  EXPECT_GT(page_->loop_thread(), 0);
}

TEST_F(LoopAndGuard, LeavesEachRowInThePage) {
  GuardsClock clock(*page_, -1);
  run(clock);
  ASSERT_EQ(page_->rows(), play_.rows.size());
  for (std::uint64_t k = 0; k < page_->rows(); ++k) {
    ASSERT_EQ(std::memcmp(page_->row(k), &play_.rows[k], sizeof(TickRecord)), 0) << "row " << k;
  }
}

TEST_F(LoopAndGuard, EndsItsRunInTheTickAfterTheGuardHasActed) {
  GuardsClock clock(*page_, 300);
  run(clock);
  EXPECT_EQ(play_.report.outcome, Outcome::faulted);
  EXPECT_EQ(play_.report.fault.fault, Fault::loop_stalled);
  EXPECT_EQ(play_.report.final_state, State::faulted);
  EXPECT_EQ(exit_code(play_.report), ExitCode::safety_trip);
  EXPECT_NE(describe(play_.report).find("the guard switched the hydraulics off"), std::string::npos);
  EXPECT_EQ(play_.rows.size(), 301U);
  EXPECT_TRUE(rig_.is_safe());
}

TEST_F(LoopAndGuard, IsNotWatchedInVirtualTime) {
  run(play_.clock);
  EXPECT_EQ(play_.report.outcome, Outcome::completed);
  EXPECT_EQ(page_->drive(), 0U);
  EXPECT_EQ(page_->rows(), play_.rows.size()) << "its rows are saved nevertheless";
}

TEST_F(LoopAndGuard, StartsTheNextRunUntripped) {
  GuardsClock clock(*page_, 300);
  run(clock);
  play_.queue = std::make_unique<RecordQueue>();
  play_.report = {};
  GuardsClock next(*page_, -1);
  run(next);
  EXPECT_EQ(play_.report.outcome, Outcome::completed) << describe(play_.report);
}

TEST(StallLimit, IsTheRigFilesOrThatOfTheKernelsKind) {
  config::RealtimeOptions options;
  KernelFacts kernel;
  EXPECT_EQ(stall_limit_ns(options, kernel), 101 * kPeriod_ns);
  kernel.preempt_rt = true;
  EXPECT_EQ(stall_limit_ns(options, kernel), 21 * kPeriod_ns);
  options.stall_limit_s = 0.15;
  options.sample_period_s = 0.01;
  EXPECT_EQ(stall_limit_ns(options, kernel), 160 * kPeriod_ns);
}

TEST(LoopPriority, IsLimitedBelowTheGuardsAndSaysSo) {
  config::RealtimeOptions options;
  options.priority = 99;
  RealtimeFacts facts;
  std::thread([&] { enter_realtime(options, facts); }).join();
  ASSERT_FALSE(facts.refused.empty());
  EXPECT_NE(facts.refused.front().find("realtime.priority = 99 is limited to 90"), std::string::npos)
      << facts.refused.front();
}

}  // namespace
}  // namespace eha::acquisition
