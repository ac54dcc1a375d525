// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/recent_samples.hpp"

#include <gtest/gtest.h>

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

Json samples(const std::string& blocks) { return {{"first", 0}, {"lost", 0}, {"blocks", Json::parse(blocks)}}; }

TEST(RecentSamples, GiveTheRangeOfRodAndVolts) {
  RecentSamples recent;
  EXPECT_EQ(recent.text(DisplayUnit("in")), "not read yet");
  recent.add(samples("[[1, 0.04, 2.9, 3.0, -1.2, 0.5], [2, 0.08, 2.95, 3.1, 0.5, 1.4]]"));
  EXPECT_EQ(recent.text({}), "2.900 to 3.100 in, -1.20 to +1.40 V");
  EXPECT_EQ(recent.text(DisplayUnit("mm")), "73.660 to 78.740 mm, -1.20 to +1.40 V");
}

TEST(RecentSamples, LeaveOutTheVoltsOfARigThatIsNotDriven) {
  RecentSamples recent;
  recent.add(samples("[[1, null, 2.9, 2.9, null, null], [2, null, null, null, null, null]]"));
  EXPECT_EQ(recent.text(DisplayUnit("in")), "2.900 to 2.900 in");
}

TEST(RecentSamples, ForgetWhatIsOlderThanASecond) {
  RecentSamples recent;
  recent.add(samples("[[1, null, 9.0, 9.0, null, null]]"));
  for (int i = 0; i < 25; ++i) recent.add(samples("[[2, null, 3.0, 3.0, null, null]]"));
  EXPECT_EQ(recent.text(DisplayUnit("in")), "3.000 to 3.000 in");
}

}  // namespace
}  // namespace eha::cli
