// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/lease.hpp"

#include <gtest/gtest.h>

namespace eha::service {
namespace {

using namespace std::chrono_literals;

TEST(Lease, IsNobodysAtFirst) {
  const Lease lease;
  EXPECT_FALSE(lease.holder());
  EXPECT_FALSE(lease.is_held_by(0));
  EXPECT_FALSE(lease.has_expired(Lease::Clock::now() + 24h));
}

TEST(Lease, EndsTenMinutesAfterTheLastCommandOfItsHolder) {
  const auto start = Lease::Clock::now();
  Lease lease;
  lease.grant({1000, "alice"}, start);
  EXPECT_TRUE(lease.is_held_by(1000));
  EXPECT_FALSE(lease.is_held_by(1001));
  EXPECT_FALSE(lease.has_expired(start + 599s));
  lease.renew(start + 599s);
  EXPECT_FALSE(lease.has_expired(start + 600s));
  EXPECT_DOUBLE_EQ(lease.remaining(start + 600s).count(), 599.0);
  EXPECT_TRUE(lease.has_expired(start + 1199s));
  lease.release();
  EXPECT_FALSE(lease.is_held_by(1000));
}

TEST(Lease, IsTakenBackOnlyWhileNoOtherOneFollowed) {
  const auto start = Lease::Clock::now();
  Lease lease;
  const auto first = lease.grant({1000, "alice"}, start);
  lease.release();
  const auto second = lease.grant({1001, "bob"}, start);
  lease.take_back(first);
  EXPECT_TRUE(lease.is_held_by(1001));
  lease.take_back(second);
  EXPECT_FALSE(lease.holder());
}

}  // namespace
}  // namespace eha::service
