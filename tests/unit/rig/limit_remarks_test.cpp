// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/limit_remarks.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <string>

namespace eha {
namespace {

using std::chrono::sys_days;
using std::chrono::year;

const sys_days kToday = year(2026) / 6 / 1;

/// What is said of a shipped rig after a change, a line each.
std::string said(const char* file, const std::function<void(config::RigConfig&)>& change, sys_days today = kToday) {
  config::RigConfig rig = config::load_rig(std::string(EHA_SOURCE_DIR "/config/rigs/") + file);
  change(rig);
  std::string lines;
  for (const std::string& sentence : limit_remarks(rig, today)) lines += sentence + '\n';
  return lines;
}

void expect(const std::string& text, const char* words) {
  EXPECT_NE(text.find(words), std::string::npos) << text;
  EXPECT_EQ(text.find('\n'), text.size() - 1) << "one line: " << text;
}

TEST(LimitRemarks, SayNothingOfTheShippedRigs) {
  for (const char* file : {"sim.toml", "sim-leaky.toml", "sim-sticky.toml", "sim-worn.toml", "pci1716.toml"}) {
    EXPECT_EQ(said(file, [](config::RigConfig&) {}), "") << file;
  }
}

TEST(LimitRemarks, SayThatNoCheckLooksForAFrozenSensor) {
  for (const char* file : {"sim.toml", "pci1716.toml"}) {
    expect(said(file, [](auto& rig) { rig.limits.frozen_sensor_s = 0.0; }), "frozen_sensor_s is off");
  }
  expect(said("sim.toml", [](auto& rig) { rig.limits.frozen_sensor_s = 60.0; }), "frozen_sensor_s = 60 s");
}

TEST(LimitRemarks, SayHowMuchADeadSensorHidesOfAWideFollowingLimit) {
  expect(said("pci1716.toml", [](auto& rig) { rig.limits.following->limit_in = 0.25; }),
         "following.limit_in = 0.25 in (6.35 mm): beside a dead sensor the rod moves by up to four times as much");
}

TEST(LimitRemarks, SayThatAVelocityLimitMakesAPlacingCreep) {
  const std::string text = said("sim.toml", [](auto& rig) { rig.limits.velocity_limit_in_per_s = 0.1; });
  expect(text, "0.1 in/s (2.54 mm/s) is below the usual 0.3 in/s (7.62 mm/s) of goto");
  expect(text, "1 in (25.4 mm) takes 100 s");
  expect(text, "3 or more");
  EXPECT_EQ(said("sim.toml", [](auto& rig) { rig.limits.velocity_limit_in_per_s = 0.3; }), "");
}

TEST(LimitRemarks, SayHowOldACalibrationIs) {
  const auto at = [](sys_days today) {
    return said(
        "pci1716.toml", [](config::RigConfig&) {}, today);
  };
  EXPECT_EQ(at(year(2027) / 1 / 2), "") << "a year and a day";
  expect(at(year(2028) / 7 / 1), "calibration_date = \"2026-01-01\": scale and offset of the sensor are 2.5 years old");
  EXPECT_EQ(at(year(2025) / 1 / 1), "") << "a clock that is wrong";
}

TEST(LimitRemarks, SayThatTheSafeVoltageMovesTheRod) {
  const auto at = [](double safe_V) { return said("sim.toml", [&](auto& rig) { rig.limits.safe_V = safe_V; }); };
  // null -0.2 V, half dead band 0.2 V with 0.05 V to spare, half gains of 0.074 and 0.065 in/(V s)
  expect(at(2.0), "limits.safe_V = 2 V is 2.2 V from the valve's null");
  expect(at(2.0), "about 0.3 in/s (7.7 mm/s)");
  expect(at(2.0), "measure the valve (`eha characterise`) before you believe that -0.2 is the null and set it");
  expect(at(-2.4), "about 0.27 in/s (6.8 mm/s)");
  EXPECT_EQ(at(-0.4), "");
  const auto unknown = [](double safe_V) {
    return said("sim.toml", [&](auto& rig) {
      rig.limits.following.reset();
      rig.limits.safe_V = safe_V;
    });
  };
  expect(unknown(2.0), "which is not known");
  EXPECT_EQ(unknown(0.5), "");
}

TEST(LimitRemarks, SayThatALoopMayBeLateForLongOnAMachineAlone) {
  const auto late = [](auto& rig) { rig.realtime.abort_consecutive_late = 1000; };
  expect(said("pci1716.toml", late), "late for 1 s in a row; set at most 100");
  EXPECT_EQ(said("sim.toml", late), "");
}

}  // namespace
}  // namespace eha
