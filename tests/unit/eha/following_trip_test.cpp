// SPDX-License-Identifier: GPL-3.0-or-later
// What a trip leads to.
#include "daemon/eha/following_trip.hpp"

#include <gtest/gtest.h>

#include "config/rig_config.hpp"
#include "daemon/eha/next_command.hpp"

namespace eha::cli {
namespace {

TEST(FollowingTrip, LeavesFollowingOutWhereItMayBeWrongAndNotAtALimitOfTheTravel) {
  const config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  ASSERT_TRUE(rig.limits.following);
  const suggest::RigAccess access{.is_local = true, .rig_file = "sim.toml"};
  for (const char* fault : {"no_motion", "not_in_place", "wrong_speed", "not_following", "unexplained_motion"}) {
    EXPECT_EQ(next_after_trip(std::string(fault) + " at 3.5 s: the rod", &rig, access),
              suggest::without_following(access))
        << fault;
  }
  EXPECT_EQ(next_after_trip("travel_limit at 3.5 s: the rod is at 5.75 in", &rig, access), suggest::read(access));
  EXPECT_EQ(next_after_trip("no_motion at 3.5 s", nullptr, access), suggest::read(access)) << "of an unknown rig";
}

}  // namespace
}  // namespace eha::cli
