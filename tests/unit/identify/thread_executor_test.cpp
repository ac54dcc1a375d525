// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/thread_executor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <latch>
#include <stdexcept>
#include <string>
#include <vector>

namespace eha::identify {
namespace {

TEST(ThreadExecutor, RunsEachTaskOnce) {
  for (const unsigned threads : {1U, 2U, 7U}) {
    std::vector<std::atomic<int>> runs(100);
    thread_executor(threads)(runs.size(), [&](std::size_t i) { ++runs[i]; });
    EXPECT_TRUE(std::all_of(runs.begin(), runs.end(), [](const auto& count) { return count == 1; })) << threads;
  }
}

TEST(ThreadExecutor, RunsAsManyTasksAtATimeAsItHasThreads) {
  std::latch all_there(3);  // passes only when three tasks are under way together
  thread_executor(3)(3, [&](std::size_t) { all_there.arrive_and_wait(); });
  EXPECT_TRUE(all_there.try_wait());
}

TEST(ThreadExecutor, DoesNothingForNoTasks) {
  bool called = false;
  thread_executor()(0, [&](std::size_t) { called = true; });
  EXPECT_FALSE(called);
}

TEST(ThreadExecutor, ThrowsTheFailureOfATaskAgain) {
  try {
    thread_executor(2)(10, [](std::size_t i) {
      if (i == 3) throw std::runtime_error("third");
    });
    FAIL() << "no exception";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()), "third");
  }
}

TEST(ThreadExecutor, MayBeUsedInsideATask) {
  std::atomic<int> runs = 0;
  const ident::Executor executor = thread_executor(2);
  executor(3, [&](std::size_t) { executor(4, [&](std::size_t) { ++runs; }); });
  EXPECT_EQ(runs, 12);
}

}  // namespace
}  // namespace eha::identify
