// SPDX-License-Identifier: GPL-3.0-or-later
// What a trip leads to.
#include "daemon/eha/following_trip.hpp"

#include <gtest/gtest.h>

#include "config/rig_config.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/record/report_json.hpp"

namespace eha::cli {
namespace {

TEST(FollowingTrip, LeavesFollowingOutWhereItMayBeWrongAndNotAtALimitOfTheTravel) {
  const config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  ASSERT_TRUE(rig.limits.following);
  const suggest::RigAccess access{.is_local = true, .rig_file = "sim.toml"};
  for (const char* fault : {"no_motion", "not_in_place", "wrong_speed", "not_following", "unexplained_motion"}) {
    EXPECT_EQ(next_after_trip({.fault = fault}, &rig, access), suggest::without_following(access)) << fault;
  }
  EXPECT_EQ(next_after_trip({.fault = "travel_limit"}, &rig, access), suggest::read(access));
  EXPECT_EQ(next_after_trip({.fault = "no_motion"}, nullptr, access), suggest::read(access)) << "of an unknown rig";
  // No pressure and a valve without its plug come first; a wrong null moves the rod, however little.
  using acquisition::Fault;
  EXPECT_EQ(next_after_trip(trip_of({.fault = Fault::no_motion, .value = 0.0001, .limit = 0.05}), &rig, access),
            suggest::read(access));
  EXPECT_EQ(next_after_trip(trip_of({.fault = Fault::no_motion, .value = 0.003, .limit = 0.0}), &rig, access),
            suggest::without_following(access));
}

TEST(FollowingTrip, KnowsAJumpOfTheReadingByItsFiguresNotByWords) {
  using acquisition::Fault;
  EXPECT_FALSE(may_be_of_following(trip_of({.fault = Fault::velocity_limit, .value = -122.3, .limit = -8.0})));
  EXPECT_TRUE(may_be_of_following(trip_of({.fault = Fault::velocity_limit, .value = -9.0, .limit = -8.0})));
  EXPECT_FALSE(may_be_of_following(trip_of({.fault = Fault::not_in_place, .value = 0.005, .limit = 0.02})));
  EXPECT_TRUE(may_be_of_following(trip_of({.fault = Fault::not_in_place, .value = 0.3, .limit = 0.02})));
  EXPECT_FALSE(may_be_of_following(trip_of(acquisition::FaultReport{})));
  for (const double value : {0.005, 0.3}) {
    record::Manifest manifest = record::manifest_from_header({{"name", "sine"}});
    acquisition::RunReport report;
    report.outcome = acquisition::Outcome::faulted;
    report.fault = {.fault = Fault::not_in_place, .value = value, .limit = 0.02};
    record::put_report(manifest, report, "");
    EXPECT_EQ(may_be_of_following(trip_of(manifest)), value > 0.02);
  }
}

TEST(FollowingTrip, KnowsTheFaultOfAKilledRunByTheJournalsEndOrByItsRows) {
  using acquisition::Fault;
  record::Manifest manifest = record::manifest_from_header({{"name", "sine"}});
  manifest.outcome = acquisition::Outcome::recovered;
  manifest.recovery = record::RecoveryEntry{};
  EXPECT_EQ(trip_of(manifest).fault, "");
  manifest.other[record::kFaultOfRows] = "sensor_slip";
  EXPECT_EQ(trip_of(manifest).fault, "sensor_slip");
  EXPECT_TRUE(trip_of(manifest).reading_jumps);
  manifest.other.erase(record::kFaultOfRows);
  acquisition::RunReport report;
  report.fault = {.fault = Fault::no_motion, .value = 0.01, .limit = 0.2};
  manifest.recovery->end = record::describe_end(report);
  EXPECT_EQ(trip_of(manifest).fault, "no_motion");
  EXPECT_FALSE(trip_of(manifest).reading_jumps);
}

}  // namespace
}  // namespace eha::cli
