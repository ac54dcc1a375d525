// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/audit_limiter.hpp"

#include <gtest/gtest.h>

namespace eha::service {
namespace {

using namespace std::chrono_literals;

TEST(AuditLimiter, LetsABurstThroughAndCountsWhatItLeavesOut) {
  AuditLimiter limiter;
  const auto now = AuditLimiter::Clock::now();
  int logged = 0;
  for (int i = 0; i < 1000; ++i) logged += limiter.take(1000, now) ? 1 : 0;
  EXPECT_EQ(logged, static_cast<int>(AuditLimiter::kBurst));
  EXPECT_EQ(limiter.take(1000, now + 1s), 950U);
  EXPECT_EQ(limiter.take(1000, now + 1s), 0U) << "the count starts anew";
}

TEST(AuditLimiter, LimitsEachUserAlone) {
  AuditLimiter limiter;
  const auto now = AuditLimiter::Clock::now();
  while (limiter.take(1000, now)) {
  }
  EXPECT_EQ(limiter.take(1001, now), 0U);
}

TEST(AuditLimiter, LetsAQuietUserHaveNoMoreThanABurst) {
  AuditLimiter limiter;
  const auto now = AuditLimiter::Clock::now();
  static_cast<void>(limiter.take(1000, now));
  int logged = 0;
  while (limiter.take(1000, now + 24h)) ++logged;
  EXPECT_EQ(logged, static_cast<int>(AuditLimiter::kBurst));
}

}  // namespace
}  // namespace eha::service
