// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/recorded_gain.hpp"

#include <gtest/gtest.h>

namespace eha::cli {
namespace {

TEST(RecordedGain, SaysWhyAMorePreciseRunIsNotTaken) {
  const Recorded first{.folder = "runs/1-band", .outcome = "completed", .gain_percent = 0.84, .model = "io3_valve"};
  const Recorded rejected{.folder = "runs/2-band", .outcome = "completed", .gain_percent = 0.31, .model = {}};
  EXPECT_EQ(
      why_taken(first, rejected),
      "by 2-band the gain is known to +-0.31 %, but no model of it passes; 1-band is taken, whose io3_valve does");
  const Recorded better{.folder = "runs/3-band", .outcome = "completed", .gain_percent = 0.4, .model = "io_valve"};
  EXPECT_EQ(
      why_taken(better, first),
      "by 3-band the gain is known to +-0.4 %, by 1-band the gain is known to +-0.84 %: 3-band is taken, the more "
      "precise one");
  const Recorded unknown{.folder = "runs/4-band", .outcome = "completed", .model = "io_valve"};
  EXPECT_EQ(why_taken(first, unknown),
            "by 1-band the gain is known to +-0.84 %, by 4-band the gain has no interval: 1-band is taken, the more "
            "precise one");
  const Recorded alike{.folder = "runs/5-band", .outcome = "completed", .model = "io_valve"};
  EXPECT_NE(why_taken(unknown, alike).find("4-band is taken, the first one"), std::string::npos);
}

}  // namespace
}  // namespace eha::cli
