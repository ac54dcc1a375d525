// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <string>

#include "daemon/acquisition/run_report.hpp"

namespace eha::acquisition {
namespace {

/// What a rod that did not follow a closed loop is said to have done.
std::string text_of(double moved_in, double due_in, const DisplayUnit& unit = {}) {
  RunReport report;
  report.outcome = Outcome::faulted;
  report.safe_confirmed = true;
  report.fault = {.fault = Fault::no_motion, .at_ns = 343'000'000, .value = moved_in, .limit = due_in};
  return describe(report, unit);
}

bool holds(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

TEST(FaultText, SaysOfARodThatStandsWhatWasDueAndNamesTheHydraulicsFirst) {
  const std::string text = text_of(0.0002, 0.0034);
  EXPECT_TRUE(holds(text, "it moved 0.0002 in where 0.0034 in were due; look, in this order: hydraulics on")) << text;
  EXPECT_FALSE(holds(text, "other way")) << text;
  EXPECT_TRUE(holds(text, "`eha characterise` measures both")) << text;
  EXPECT_TRUE(holds(text, "where that is what tripped: `eha characterise --without-following -o rig-bare.toml`"))
      << text;
}

TEST(FaultText, SaysOfARodThatStandsWhatWasCommandedAndForHowLong) {
  RunReport report;
  report.outcome = Outcome::faulted;
  report.safe_confirmed = true;
  report.fault = {.fault = Fault::no_motion, .value = 0.0002, .limit = 0.0034, .driven_V = -1.254, .driven_s = 0.123};
  EXPECT_TRUE(
      holds(describe(report, DisplayUnit("mm")),
            "a closed loop drove the rod for 0.12 s, at last with -1.25 V, and it moved 0.0051 mm where 0.086 mm were "
            "due; look, in this order: hydraulics on"))
      << describe(report, DisplayUnit("mm"));
  EXPECT_TRUE(holds(text_of(1.4e-05, 0.003), "and it moved 0 in where 0.003 in were due")) << text_of(1.4e-05, 0.003);
}

TEST(FaultText, NamesTheNullFirstWhereTheRodMovedTheOtherWay) {
  const std::string text = text_of(-0.0021, 0.00092);
  EXPECT_TRUE(holds(text, "the sensor shows 0.0021 in the other way where 0.00092 in were due")) << text;
  EXPECT_TRUE(holds(text,
                    "likely, in this order: the null of [following] in the rig file is wrong, the sign of valve or "
                    "sensor is"))
      << text;
  EXPECT_FALSE(holds(text, "hydraulics")) << text;
  EXPECT_TRUE(holds(text, "`eha characterise --without-following -o rig-bare.toml`")) << text;
}

TEST(FaultText, PrintsNoDistanceBelowTheNoiseOfASensor) {
  const std::string text = text_of(-0.00295, 4.2e-05, DisplayUnit("mm"));
  EXPECT_TRUE(holds(text, "the sensor shows 0.075 mm of motion while no motion was due")) << text;
  EXPECT_FALSE(holds(text, "e-0")) << text;
}

TEST(FaultText, BlamesNoNullForAReadingThatOnlyTrembled) {
  const std::string text = text_of(-0.0004, 0.0031);
  EXPECT_TRUE(holds(text, "hydraulics on")) << text;
  EXPECT_FALSE(holds(text, "other way")) << text;
}

TEST(FaultText, SaysOfARodThatMovedWhichWayAndThatItWasMoreThanDue) {
  const std::string more = text_of(0.031, 0.0034);
  EXPECT_TRUE(holds(more, "the sensor shows 0.031 in of motion where 0.0034 in were due: not the motion of its volts"))
      << more;
  EXPECT_FALSE(holds(more, "hydraulics")) << more;
  const std::string back = text_of(-0.3, 0.5);
  EXPECT_TRUE(holds(back, "the sensor shows 0.3 in the other way where 0.5 in were due")) << back;
  EXPECT_FALSE(holds(text_of(-0.0004, 0.0031), "-0.0")) << "no way has a sign";
}

TEST(FaultText, BlamesTheSensorForAnErrorThatNoValveMakesInTheTime) {
  RunReport report;
  report.outcome = Outcome::faulted;
  report.safe_confirmed = true;
  report.experiment_ns = 1'000'000'000;
  report.fault = {.fault = Fault::following_error, .at_ns = 1'003'000'000, .value = 0.033, .limit = 0.014};
  EXPECT_TRUE(holds(describe(report, DisplayUnit()), kReadingJumps.data())) << describe(report, DisplayUnit());
  EXPECT_FALSE(holds(describe(report, DisplayUnit()), "eha characterise")) << describe(report, DisplayUnit());
  report.fault.at_ns = 2'400'000'000;
  EXPECT_TRUE(holds(describe(report, DisplayUnit()), "the supply pressure or the valve has changed"));
}

TEST(FaultText, BlamesNoTableForAReadingThatScattersAboutItsPlace) {
  RunReport report;
  report.outcome = Outcome::faulted;
  report.safe_confirmed = true;
  report.fault = {.fault = Fault::not_in_place, .at_ns = 120'000'000'000, .value = 0.005, .limit = 0.02};
  const std::string text = describe(report, DisplayUnit());
  EXPECT_TRUE(holds(text, "0.005 in from its place at the time-out, near enough, but did not rest")) << text;
  EXPECT_TRUE(holds(text, kReadingJumps.data())) << text;
  EXPECT_FALSE(holds(text, "[following]")) << text;
  report.fault.value = 0.3;
  EXPECT_TRUE(holds(describe(report, DisplayUnit()), "look at [following]"));
}

TEST(FaultText, SaysOfASlipHowTheRigIsArmedAgain) {
  RunReport report;
  report.outcome = Outcome::faulted;
  report.safe_confirmed = true;
  report.fault = {.fault = Fault::sensor_slip, .at_ns = 56'000'000, .value = 0.07, .limit = 0.05};
  EXPECT_TRUE(holds(describe(report),
                    "`eha arm --ruler LENGTH` arms where they agree, else `eha calibrate "
                    "--sensor-moved`"))
      << describe(report);
  EXPECT_TRUE(reading_jumped(report.fault));
}

TEST(FaultText, BlamesTheSensorForASpeedThatNoRodHas) {
  RunReport report;
  report.outcome = Outcome::faulted;
  report.safe_confirmed = true;
  report.fault = {.fault = Fault::velocity_limit, .at_ns = 56'000'000, .value = -122.3, .limit = -8.0};
  const std::string noise = describe(report);
  EXPECT_TRUE(holds(noise, "low-pass filter")) << noise;
  EXPECT_FALSE(holds(noise, "lower the excitation")) << "which does not help";
  EXPECT_TRUE(reading_jumped(report.fault));
  report.fault.value = -9.0;
  EXPECT_FALSE(reading_jumped(report.fault));
  EXPECT_TRUE(holds(describe(report), "lower the excitation")) << describe(report);
}

}  // namespace
}  // namespace eha::acquisition
