// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/limit_checks.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace eha::doctor {
namespace {

config::RigLimits sound_limits() {
  config::RigLimits limits;
  limits.travel_min_in = 0.5;
  limits.travel_max_in = 5.4;
  limits.velocity_limit_in_per_s = 8.0;
  limits.stopping_deceleration_in_per_s2 = 200.0;
  limits.frozen_sensor_s = 0.5;
  return limits;
}

TEST(LimitChecks, FindNothingWhereEverythingIsWatched) { EXPECT_EQ(check_limits(sound_limits(), {}).level, Level::ok); }

TEST(LimitChecks, NameEveryLimitThatProtectsFromNothing) {
  const auto warning = [](const std::function<void(config::RigLimits&, config::RealtimeOptions&)>& loosen) {
    config::RigLimits limits = sound_limits();
    config::RealtimeOptions realtime;
    loosen(limits, realtime);
    const Check check = check_limits(limits, realtime);
    EXPECT_EQ(check.level, Level::warn);
    return check.found;
  };
  const auto names = [](const std::string& text, const char* key) { return text.find(key) != std::string::npos; };
  EXPECT_TRUE(names(warning([](auto& limits, auto&) { limits.frozen_sensor_s = 0.0; }), "frozen_sensor_s is off"));
  EXPECT_TRUE(names(warning([](auto& limits, auto&) { limits.frozen_sensor_s = 60.0; }), "frozen_sensor_s = 60 s"));
  EXPECT_TRUE(names(warning([](auto& limits, auto&) { limits.velocity_limit_in_per_s = 1e6; }), "velocity_limit"));
  EXPECT_TRUE(names(warning([](auto& limits, auto&) { limits.stopping_deceleration_in_per_s2 = 1e12; }),
                    "stopping_deceleration"));
  EXPECT_TRUE(names(warning([](auto&, auto& realtime) { realtime.abort_consecutive_late = 1'000'000; }),
                    "abort_consecutive_late"));
}

}  // namespace
}  // namespace eha::doctor
