// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/time_text.hpp"

#include <gtest/gtest.h>

namespace eha {
namespace {

TEST(TimeText, ReachesTheMillisecondOfAnyClock) {
  EXPECT_EQ(time_text(12.5), "12.5");
  EXPECT_EQ(time_text(0.00025), "0.00025");
  EXPECT_EQ(time_text(3600.0), "3600");
  EXPECT_EQ(time_text(123456.789), "123456.789");
  EXPECT_EQ(time_text(1764115200.123), "1764115200.123");
  EXPECT_EQ(time_text(-1764115200.5), "-1764115200.5");
}

}  // namespace
}  // namespace eha
