// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha-safe/stall_watch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>

namespace eha {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::uint32_t kDrive = 1;

/// A watch that has looked every 5 ms at a loop that beats.
class StallWatchTest : public ::testing::Test {
 protected:
  StallWatchTest() {
    for (int i = 0; i < 10; ++i) look(5 * kMs, 5);
  }
  std::int64_t look(std::int64_t elapsed_ns, std::uint64_t beats, std::uint32_t drive = kDrive) {
    now_ns_ += elapsed_ns;
    beats_ += beats;
    return watch_.look(drive, beats_, now_ns_);
  }

  StallWatch watch_;
  std::int64_t now_ns_ = 0;
  std::uint64_t beats_ = 0;
};

TEST_F(StallWatchTest, AddsUpPunctualLooksWithoutABeat) {
  EXPECT_EQ(look(5 * kMs, 5), 0);
  for (int i = 1; i <= 30; ++i) EXPECT_EQ(look(5 * kMs, 0), i * 5 * kMs);
  EXPECT_EQ(look(5 * kMs, 1), 0) << "one beat ends a stall";
}

TEST_F(StallWatchTest, CountsNoTimeInWhichItStoodStillItself) {
  EXPECT_EQ(look(5 * kMs, 0), 5 * kMs);
  EXPECT_EQ(look(500 * kMs, 0), 5 * kMs);
  EXPECT_EQ(look(5 * kMs, 0), 10 * kMs);
}

TEST_F(StallWatchTest, StartsAnewWithEachRun) {
  for (int i = 0; i < 20; ++i) look(5 * kMs, 0);
  EXPECT_EQ(look(5 * kMs, 0, kDrive + 2), 0);
}

/// What a replay of recorded looks comes to.
struct Replay {
  int looks = 0;
  std::int64_t longest_look_ns = 0;
  std::int64_t stalled_ns = 0;  ///< the greatest that the watch reported
};

/// Looks of a guard at SCHED_FIFO 95 beside a loop at 80, on a virtual machine with two processors that compilers kept
/// busy: time since the look before [us], beats since then.
Replay replay(const std::string& name) {
  std::ifstream file(std::string(EHA_SOURCE_DIR) + "/tests/unit/eha-safe/" + name);
  StallWatch watch;
  Replay result;
  std::int64_t now_ns = 0;
  std::uint64_t beats = 0;
  for (std::string line; std::getline(file, line);) {
    long elapsed_us = 0;
    unsigned long made = 0;
    if (std::sscanf(line.c_str(), "%ld,%lu", &elapsed_us, &made) != 2) continue;
    now_ns += elapsed_us * 1000;
    beats += made;
    result.stalled_ns = std::max(result.stalled_ns, watch.look(kDrive, beats, now_ns));
    result.longest_look_ns = std::max(result.longest_look_ns, std::int64_t{elapsed_us} * 1000);
    ++result.looks;
  }
  return result;
}

TEST(StallWatch, GivesNoFalseAlarmOnTheStallsOfARecordedMachine) {
  const Replay paused = replay("stalls.csv");
  ASSERT_GT(paused.looks, 100);
  EXPECT_GT(paused.longest_look_ns, 40 * kMs) << "the record holds no host that took the processors away";
  EXPECT_LT(paused.stalled_ns, 20 * kMs) << "the limit on a PREEMPT_RT kernel would have been exceeded";
}

TEST(StallWatch, FindsTheStarvedLoopInTheSameRecord) { EXPECT_GT(replay("starved.csv").stalled_ns, 600 * kMs); }

}  // namespace
}  // namespace eha
