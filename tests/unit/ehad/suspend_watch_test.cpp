// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/suspend_watch.hpp"

#include <gtest/gtest.h>

namespace eha::service {
namespace {

using namespace std::chrono_literals;

TEST(SuspendWatch, ReportsASuspendOnceAndWithItsLength) {
  SuspendWatch watch;
  EXPECT_FALSE(watch.check(5h)) << "the suspends before the start do not count";
  EXPECT_FALSE(watch.check(5h + 1us));
  const auto suspended = watch.check(5h + 3s);
  ASSERT_TRUE(suspended);
  EXPECT_NEAR(suspended->count(), 3.0, 1e-5);
  EXPECT_FALSE(watch.check(5h + 3s));
}

TEST(SuspendWatch, TakesNoPauseBetweenTwoClocksForASuspend) {
  SuspendWatch watch;
  EXPECT_FALSE(watch.check(0ns));
  EXPECT_FALSE(watch.check(50ms));
  EXPECT_FALSE(watch.check(0ns));
  EXPECT_FALSE(watch.check());
}

}  // namespace
}  // namespace eha::service
