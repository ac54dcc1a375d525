// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/deadline_monitor.hpp"

#include <gtest/gtest.h>

namespace eha::acquisition {
namespace {

config::RealtimeOptions options() {
  config::RealtimeOptions result;
  result.abort_consecutive_late = 5;
  result.abort_total_late = 50;
  return result;
}

TEST(DeadlineMonitor, EndsTheRunAtTheFifthLateTickInARow) {
  DeadlineMonitor monitor(options(), LatePolicy::abort);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(monitor.note(0, true).fault, Fault::none);
  const Breach breach = monitor.note(0, true);
  EXPECT_EQ(breach.fault, Fault::consecutive_late);
  EXPECT_DOUBLE_EQ(breach.value, 5.0);
}

TEST(DeadlineMonitor, CountsSkippedTicksLikeLateOnes) {
  DeadlineMonitor monitor(options(), LatePolicy::abort);
  EXPECT_EQ(monitor.note(4, false).fault, Fault::none);
  EXPECT_EQ(monitor.note(1, false).fault, Fault::consecutive_late);
}

TEST(DeadlineMonitor, ForgetsARowOfLateTicksAfterOneInTime) {
  DeadlineMonitor monitor(options(), LatePolicy::abort);
  for (int round = 0; round < 10; ++round) {
    EXPECT_EQ(monitor.note(4, false).fault, Fault::none);
    EXPECT_EQ(monitor.note(0, false).fault, Fault::none);
  }
}

TEST(DeadlineMonitor, EndsTheRunWhenLateTicksAddUpFasterThanOneASecond) {
  DeadlineMonitor monitor(options(), LatePolicy::abort);
  int ticks = 0;
  Breach breach;
  while (breach.fault == Fault::none && ticks < 1'000'000) breach = monitor.note(0, ++ticks % 100 == 0);
  EXPECT_EQ(breach.fault, Fault::total_late);
  // 10 a second come, 1 a second goes: 50 are there in the sixth second.
  EXPECT_GT(ticks, 5000);
  EXPECT_LE(ticks, 6000);
}

TEST(DeadlineMonitor, ToleratesOneLateTickASecondForEver) {
  DeadlineMonitor monitor(options(), LatePolicy::abort);
  for (int k = 1; k <= 1'000'000; ++k) ASSERT_EQ(monitor.note(0, k % 1000 == 0).fault, Fault::none) << "tick " << k;
}

TEST(DeadlineMonitor, OnlyCountsWhenNothingMoves) {
  DeadlineMonitor monitor(options(), LatePolicy::count);
  for (int k = 0; k < 1000; ++k) EXPECT_EQ(monitor.note(10, true).fault, Fault::none);
}

}  // namespace
}  // namespace eha::acquisition
