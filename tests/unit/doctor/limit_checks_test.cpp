// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/limit_checks.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>

namespace eha::doctor {
namespace {

/// A card's rig with all that protects it.
config::RigConfig sound_rig() {
  config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/pci1716.toml");
  rig.is_sample = false;
  EXPECT_TRUE(rig.limits.following && rig.limits.sensor);
  return rig;
}

const std::chrono::sys_days kToday = std::chrono::year(2026) / 6 / 1;

bool names(const Check& check, const char* key) { return check.found.find(key) != std::string::npos; }

TEST(LimitChecks, FindNothingWhereEverythingIsWatched) {
  const Check check = check_limits(sound_rig(), kToday);
  EXPECT_EQ(check.level, Level::ok) << check.found;
}

TEST(LimitChecks, WarnOfWhatTheRigIsArmedWithAllTheSame) {
  const auto warning = [](const std::function<void(config::RigConfig&)>& loosen) {
    config::RigConfig rig = sound_rig();
    loosen(rig);
    Check check = check_limits(rig, kToday);
    EXPECT_EQ(check.level, Level::warn) << check.found;
    return check;
  };
  EXPECT_TRUE(names(warning([](auto& rig) { rig.limits.frozen_sensor_s = 0.0; }), "frozen_sensor_s is off"));
  EXPECT_TRUE(names(warning([](auto& rig) { rig.limits.frozen_sensor_s = 60.0; }), "frozen_sensor_s = 60 s"));
  EXPECT_TRUE(names(warning([](auto& rig) { rig.realtime.abort_consecutive_late = 1000; }), "abort_consecutive_late"));
  EXPECT_TRUE(names(warning([](auto& rig) { rig.limits.following.reset(); }), "nothing but `eha characterise"));
  EXPECT_TRUE(names(warning([](auto& rig) { rig.limits.sensor.reset(); }), "no [sensor]"));
}

TEST(LimitChecks, OfASimulatedRigSayWhatAMachineWouldBeRefusedFor) {
  config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  EXPECT_EQ(check_limits(rig, kToday).level, Level::ok) << check_limits(rig, kToday).found;
  rig.limits.following->measured_check = 1;
  const Check check = check_limits(rig, kToday);
  EXPECT_EQ(check.level, Level::warn);
  EXPECT_TRUE(names(check, "following.measured_check does not fit")) << check.found;
}

TEST(LimitChecks, DoNotCallASimulatedRodFollowedWithoutFollowing) {
  config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  rig.limits.following.reset();
  const Check check = check_limits(rig, kToday);
  EXPECT_EQ(check.level, Level::warn);
  EXPECT_TRUE(names(check, "no [following] in the rig file: experiments are not rehearsed")) << check.found;
}

TEST(LimitChecks, FailWhereTheRigCannotBeArmed) {
  config::RigConfig rig = sound_rig();
  rig.limits.velocity_limit_in_per_s = 1e9;
  const Check check = check_limits(rig, kToday);
  EXPECT_EQ(check.level, Level::fail);
  EXPECT_EQ(check.code, ExitCode::configuration);
  EXPECT_TRUE(names(check, "velocity_limit_in_per_s = 1e+09 in/s")) << check.found;
}

}  // namespace
}  // namespace eha::doctor
