// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/health.hpp"

#include <gtest/gtest.h>

namespace eha::service {
namespace {

using namespace std::chrono_literals;
using Phase = play::RunWatch::Phase;

class HealthTest : public ::testing::Test {
 protected:
  /// One look after `step`, the loop and the writer having moved or not.
  std::string look(std::chrono::milliseconds step, bool loop_moves, bool writer_moves) {
    now_ += step;
    if (loop_moves) {
      ++snapshot_.sequence;
      watch_.board.publish(snapshot_);
    }
    if (writer_moves) ++watch_.writer_turns;
    return health_.check(&watch_, beats_, now_);
  }

  Health health_;
  play::RunWatch watch_;
  acquisition::Snapshot snapshot_;
  std::uint64_t beats_ = 0;
  Health::Clock::time_point now_ = Health::Clock::now();
};

TEST_F(HealthTest, IsGoodWhileLoopAndWriterMove) {
  watch_.phase = Phase::playing;
  for (int i = 0; i < 100; ++i) EXPECT_EQ(look(1500ms, true, true), "");
}

TEST_F(HealthTest, IsBadTwoSecondsAfterTheLoopStopped) {
  watch_.phase = Phase::playing;
  EXPECT_EQ(look(200ms, true, true), "");
  EXPECT_EQ(look(2000ms, false, true), "");
  EXPECT_EQ(look(100ms, false, true), "the loop stands still");
  EXPECT_EQ(look(100ms, true, true), "");
}

TEST_F(HealthTest, IsBadTenSecondsAfterTheWriterStopped) {
  watch_.phase = Phase::playing;
  EXPECT_EQ(look(200ms, true, true), "");
  for (int i = 0; i < 10; ++i) EXPECT_EQ(look(1000ms, true, false), "");
  EXPECT_EQ(look(100ms, true, false), "the writer of the record stands still");
}

TEST_F(HealthTest, LooksAtTheWriterAloneOnceTheLoopHasEnded) {
  watch_.phase = Phase::draining;
  EXPECT_EQ(look(200ms, false, true), "");
  EXPECT_EQ(look(9000ms, false, false), "");
  EXPECT_NE(look(1100ms, false, false), "");
}

TEST_F(HealthTest, WaitsForTheFilesHoweverLongTheyTake) {
  watch_.phase = Phase::closing;
  for (int i = 0; i < 100; ++i) EXPECT_EQ(look(5000ms, false, false), "");
}

TEST_F(HealthTest, LooksAtTheIdleBeatBetweenRuns) {
  EXPECT_EQ(health_.check(nullptr, 1, now_), "");
  EXPECT_EQ(health_.check(nullptr, 2, now_ + 2s), "");
  EXPECT_EQ(health_.check(nullptr, 3, now_ + 4s), "");
  EXPECT_EQ(health_.check(nullptr, 3, now_ + 6s), "");
  EXPECT_NE(health_.check(nullptr, 3, now_ + 7s), "");
}

TEST_F(HealthTest, WaitsForTheGuardOfACardThatRefusesTheSafeVoltage) {
  EXPECT_EQ(health_.check(nullptr, 1, now_, Health::kUnsafePatience), "");
  EXPECT_EQ(health_.check(nullptr, 1, now_ + 29s, Health::kUnsafePatience), "");
  EXPECT_NE(health_.check(nullptr, 1, now_ + 31s, Health::kUnsafePatience), "");
}

}  // namespace
}  // namespace eha::service
