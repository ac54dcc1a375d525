// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/rig_config.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/error.hpp"
#include "edited.hpp"

namespace eha::config {
namespace {

const char* const kLimits = R"([limits]
command_min_V = -4.0
command_max_V = 4.5
slew_V_per_s = 20.0
safe_V = 0.5
travel_min_in = 0.2
travel_max_in = 5.5
stopping_deceleration_in_per_s2 = 100.0
velocity_limit_in_per_s = 6.0
frozen_sensor_s = 0.25
)";

/// [limits] starts in line 4, [realtime] in line 14, [sim] in line 20.
const std::string kSim = std::string("schema = 1\nname = \"bench\"\nbackend = \"sim\"\n") + kLimits +
                         R"([realtime]
sample_period_s = 0.002
priority = 70
cpu = 1
abort_consecutive_late = 3
abort_total_late = 30
[sim]
bore_mm = 50.0
seed = 12
resolution_bits = 12
initial_displacement_in = 2.5
)";

/// [comedi] starts in line 14.
const std::string kCard = std::string("schema = 1\nname = \"bench\"\nbackend = \"comedi\"\n") + kLimits +
                          R"([comedi]
device = "/dev/comedi1"
board = "pci1716"
driver = "adv_pci1710"
resolution_bits = 16
feedback_settling_us = 20.0
heartbeat = "none"
scale_in_per_V = 0.3
offset_in = 2.9
calibration_date = "2025-11-30"
[comedi.feedback]
subdevice = 0
channel = 2
reference = "diff"
range_min_V = -10.0
range_max_V = 10.0
[comedi.command]
subdevice = 1
channel = 1
reference = "ground"
range_min_V = -5.0
range_max_V = 5.0
[comedi.emergency_stop]
subdevice = 2
channel = 3
active = "high"
[comedi.enable]
subdevice = 3
channel = 4
active = "low"
)";

std::vector<std::string> faults_of(const std::string& text) {
  try {
    (void)parse_rig(text, "r.toml");
  } catch (const ConfigError& error) {
    return error.lines();
  }
  return {};
}

TEST(RigConfig, TakesFollowingAndSensorAndNeedsNeither) {
  EXPECT_FALSE(parse_rig(kSim, "r.toml").limits.following.has_value());
  EXPECT_FALSE(parse_rig(kSim, "r.toml").limits.sensor.has_value());
  const std::string following =
      "[following]\ngain_positive_in_per_V_s = 0.2\ngain_negative_in_per_V_s = 0.1\nnull_V = -0.2\ndead_band_V = 0.3\n";
  const RigLimits limits =
      parse_rig(kCard + following + "[sensor]\nvalid_min_V = -9.5\nvalid_max_V = 9.0\nopen_circuit_V = 10\n", "r.toml")
          .limits;
  ASSERT_TRUE(limits.following && limits.sensor);
  EXPECT_EQ(limits.following->gain_positive_in_per_V_s, 0.2);
  EXPECT_EQ(limits.following->gain_negative_in_per_V_s, 0.1);
  EXPECT_EQ(limits.following->null_V, -0.2);
  EXPECT_EQ(limits.following->dead_band_V, 0.3);
  EXPECT_EQ(limits.following->limit_in, 0.1);
  EXPECT_EQ(limits.following->pressure_delay_s, 0.0);
  EXPECT_FALSE(limits.following->null_uncertainty_V.has_value());
  EXPECT_EQ(limits.sensor->valid_min_V, -9.5);
  EXPECT_EQ(limits.sensor->valid_max_V, 9.0);
  EXPECT_EQ(limits.sensor->open_circuit_V, 10.0);
  const std::string unknown = "[sensor]\nvalid_min_V = -9.5\nvalid_max_V = 9.0\nopen_circuit_V = \"unknown\"\n";
  EXPECT_FALSE(parse_rig(kCard + unknown, "r.toml").limits.sensor->open_circuit_V.has_value());
}

TEST(RigConfig, TakesHowWellTheValveIsKnown) {
  const std::string following =
      "[following]\ngain_positive_in_per_V_s = 0.2\ngain_negative_in_per_V_s = 0.1\nnull_V = -0.2\ndead_band_V = 0.3\n";
  const RigConfig rig =
      parse_rig(kCard + following +
                    "null_uncertainty_V = 0.008\ndead_band_uncertainty_V = 0.009\ngain_uncertainty_percent = 1.5\n",
                "r.toml");
  EXPECT_EQ(rig.limits.following->null_uncertainty_V, 0.008);
  EXPECT_EQ(rig.limits.following->dead_band_uncertainty_V, 0.009);
  EXPECT_EQ(rig.limits.following->gain_uncertainty_percent, 1.5);
  const auto faults = faults_of(kCard + following + "null_uncertainty_V = -0.008\n");
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_NE(faults[0].find("following.null_uncertainty_V: expected"), std::string::npos) << faults[0];
}

TEST(RigConfig, RefusesASensorBandThatCutsTheTravelOrSaysNothingOfAnOpenWire) {
  const auto faults = faults_of(kCard + "[sensor]\nvalid_min_V = -5.0\nvalid_max_V = 11.0\nopen_circuit_V = 0.0\n");
  ASSERT_EQ(faults.size(), 2U);
  EXPECT_NE(faults[0].find("sensor.valid_min_V: expected a voltage between the lowest"), std::string::npos)
      << faults[0];
  EXPECT_NE(faults[1].find("sensor.valid_max_V"), std::string::npos) << faults[1];
  const auto silent = faults_of(kCard + "[sensor]\nvalid_min_V = -9.5\nvalid_max_V = 9.0\n");
  ASSERT_EQ(silent.size(), 1U);
  EXPECT_NE(silent[0].find("sensor.open_circuit_V: expected a number or \"unknown\""), std::string::npos) << silent[0];
}

TEST(RigConfig, TakesAUnitOfLengthsForPeopleAndNoOther) {
  EXPECT_EQ(parse_rig(kSim, "r.toml").units, "");
  EXPECT_EQ(parse_rig("units = \"mm\"\n" + std::string(kSim), "r.toml").units, "mm");
  const std::vector<std::string> faults = faults_of("units = \"miles\"\n" + std::string(kSim));
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_NE(faults[0].find("r.toml:1:"), std::string::npos) << faults[0];
  EXPECT_NE(faults[0].find("units"), std::string::npos) << faults[0];
}

TEST(RigConfig, TakesEveryKeyOfASimulatedRigToItsPlace) {
  const RigConfig rig = parse_rig(kSim, "r.toml");
  EXPECT_EQ(rig.name, "bench");
  EXPECT_TRUE(std::holds_alternative<hal::SimOptions>(rig.backend));
  EXPECT_EQ(rig.limits.command_min_V, -4.0);
  EXPECT_EQ(rig.limits.command_max_V, 4.5);
  EXPECT_EQ(rig.limits.slew_V_per_s, 20.0);
  EXPECT_EQ(rig.limits.safe_V, 0.5);
  EXPECT_EQ(rig.limits.travel_min_in, 0.2);
  EXPECT_EQ(rig.limits.travel_max_in, 5.5);
  EXPECT_EQ(rig.limits.stopping_deceleration_in_per_s2, 100.0);
  EXPECT_EQ(rig.limits.velocity_limit_in_per_s, 6.0);
  EXPECT_EQ(rig.limits.frozen_sensor_s, 0.25);
  EXPECT_EQ(rig.realtime.sample_period_s, 0.002);
  EXPECT_EQ(rig.realtime.priority, 70);
  EXPECT_EQ(rig.realtime.cpu, 1);
  EXPECT_EQ(rig.realtime.abort_consecutive_late, 3);
  EXPECT_EQ(rig.realtime.abort_total_late, 30);
  EXPECT_EQ(rig.realtime.stall_limit_s, std::nullopt);
  hal::SimOptions sim;
  sim.bore_mm = 50.0;
  sim.seed = 12;
  sim.resolution_bits = 12;
  sim.initial_displacement_in = 2.5;
  EXPECT_EQ(std::get<hal::SimOptions>(rig.backend), sim);
  EXPECT_EQ(rig.text, kSim);
}

TEST(RigConfig, TakesEveryKeyOfACardToItsPlace) {
  const RigConfig rig = parse_rig(kCard, "r.toml");
  ASSERT_TRUE(std::holds_alternative<hal::ComediOptions>(rig.backend));
  const auto& card = std::get<hal::ComediOptions>(rig.backend);
  EXPECT_EQ(card.device, "/dev/comedi1");
  EXPECT_EQ(card.board, "pci1716");
  EXPECT_EQ(card.driver, "adv_pci1710");
  EXPECT_EQ(card.feedback_settling_us, 20.0);
  EXPECT_EQ(card.feedback.channel, 2U);
  EXPECT_EQ(card.feedback.reference, hal::AnalogReference::diff);
  EXPECT_EQ(card.feedback.range_min_V, -10.0);
  EXPECT_EQ(card.command.subdevice, 1U);
  EXPECT_EQ(card.command.reference, hal::AnalogReference::ground);
  EXPECT_EQ(card.command.range_max_V, 5.0);
  ASSERT_TRUE(card.emergency_stop.has_value());
  EXPECT_EQ(card.emergency_stop->channel, 3U);
  ASSERT_TRUE(card.enable.has_value());
  EXPECT_EQ(card.enable->active, hal::ActiveLevel::low);
  EXPECT_FALSE(card.heartbeat.has_value());
  EXPECT_EQ(card.scale_in_per_V, 0.3);
  EXPECT_EQ(card.offset_in, 2.9);
  EXPECT_EQ(card.calibration_date, "2025-11-30");
}

TEST(RigConfig, HasRealtimeDefaultsAndNoCpu) {
  const std::string text = kSim.substr(0, kSim.find("[realtime]")) + "[sim]\n";
  const RigConfig rig = parse_rig(text, "r.toml");
  EXPECT_EQ(rig.realtime.sample_period_s, 0.001);
  EXPECT_FALSE(rig.realtime.cpu.has_value());
}

struct Edit {
  const std::string* base;
  std::string passage;
  std::string replacement;
  std::vector<std::string> lines;  ///< expected, without the file name
};

void PrintTo(const Edit& edit, std::ostream* stream) { *stream << edit.passage << " -> " << edit.replacement; }

class FaultyRig : public testing::TestWithParam<Edit> {};

TEST_P(FaultyRig, IsRefusedWithPlaceKeyAndValue) {
  std::vector<std::string> expected;
  for (const std::string& line : GetParam().lines) expected.push_back("r.toml:" + line);
  EXPECT_EQ(faults_of(edited(*GetParam().base, GetParam().passage, GetParam().replacement)), expected);
}

INSTANTIATE_TEST_SUITE_P(
    Common, FaultyRig,
    testing::Values(
        Edit{&kSim, "schema = 1", "schema = \"1\"", {"1:10: schema: expected 1, got \"1\""}},
        Edit{&kSim, "name = \"bench\"", "name = \"\"", {"2:8: name: expected a string that is not empty, got \"\""}},
        Edit{&kSim,
             "backend = \"sim\"",
             "backend = \"simulator\"",
             {"3:11: backend: expected \"sim\" or \"comedi\", got \"simulator\""}},
        Edit{&kSim,
             "backend = \"sim\"",
             "backend = \"comedi\"",
             {"1:1: comedi: expected a table, got no such key",
              "20:1: sim: expected no such key (backend = \"comedi\"), got a table"}},
        Edit{&kSim, "safe_V = 0.5\n", "", {"4:1: limits.safe_V: expected a number from -10 to 10, got no such key"}},
        Edit{&kSim,
             "safe_V = 0.5",
             "safe_V = 4.6",
             {"8:10: limits.safe_V: expected a voltage within command_min_V..command_max_V, -4..4.5, got 4.6"}},
        Edit{&kSim,
             "command_max_V = 4.5",
             "command_max_V = -4",
             {"6:17: limits.command_max_V: expected more than command_min_V = -4, got -4"}},
        Edit{&kSim,
             "command_max_V = 4.5",
             "command_max_V = 11",
             {"6:17: limits.command_max_V: expected a number from -10 to 10, got 11"}},
        Edit{&kSim,
             "slew_V_per_s = 20.0",
             "slew_V_per_s = 0",
             {"7:16: limits.slew_V_per_s: expected a number above 0, got 0"}},
        Edit{&kSim,
             "travel_max_in = 5.5",
             "travel_max_in = 0.1",
             {"10:17: limits.travel_max_in: expected more than travel_min_in = 0.2, got 0.1"}},
        Edit{&kSim,
             "travel_max_in = 5.5",
             "travel_max_in = 7",
             {"10:17: limits.travel_max_in: expected a displacement that the sensor can show, -6..6 in, got 7"}},
        Edit{&kSim,
             "travel_max_in = 5.5",
             "travel_max_in = 146",
             {"10:17: limits.travel_max_in: expected a displacement that the sensor can show, -6..6 in (millimetres? "
              "write travel_max_mm), got 146"}},
        Edit{&kSim,
             "velocity_limit_in_per_s = 6.0",
             "velocity_limit_in_per_s = inf",
             {"12:27: limits.velocity_limit_in_per_s: expected a number above 0, got inf"}},
        Edit{&kSim,
             "velocity_limit_in_per_s = 6.0",
             "velocity_limit_cm_per_s = 150.0",
             {"4:1: limits.velocity_limit_in_per_s: expected a number above 0, got no such key",
              "12:1: limits.velocity_limit_cm_per_s: expected a known key (did you mean \"velocity_limit_in_per_s\"?), "
              "got an unknown one"}},
        Edit{&kSim,
             "priority = 70",
             "priority = \"high\"",
             {"16:12: realtime.priority: expected an integer from 1 to 99, got \"high\""}},
        Edit{&kSim,
             "sample_period_s = 0.002",
             "sample_period_s = 0",
             {"15:19: realtime.sample_period_s: expected a number from 0.0001 to 1, got 0"}},
        Edit{&kSim, "cpu = 1", "cpu = -1", {"17:7: realtime.cpu: expected an integer from 0 to 1023, got -1"}},
        Edit{&kSim,
             "abort_total_late = 30",
             "abort_total_late = 0",
             {"19:20: realtime.abort_total_late: expected an integer from 1 to 1000000, got 0"}},
        Edit{&kSim,
             "abort_total_late = 30",
             "abort_total_late = 30\nstall_limit_s = 0",
             {"20:17: realtime.stall_limit_s: expected a number from 0.01 to 1, got 0"}}));

INSTANTIATE_TEST_SUITE_P(
    Simulated, FaultyRig,
    testing::Values(
        Edit{&kSim, "bore_mm = 50.0", "bore_mm = 20.0", {"20:1: sim.rod_mm: expected less than bore_mm = 20, got 20"}},
        Edit{&kSim,
             "bore_mm = 50.0",
             "boer_mm = 50.0",
             {"21:1: sim.boer_mm: expected a known key (did you mean \"bore_mm\"?), got an unknown one"}},
        Edit{&kSim,
             "bore_mm = 50.0",
             "bore_mm = \"wide\"",
             {"21:11: sim.bore_mm: expected a finite number, got \"wide\""}},
        Edit{&kSim,
             "resolution_bits = 12",
             "resolution_bits = 25",
             {"23:19: sim.resolution_bits: expected an integer from 8 to 24, got 25"}},
        Edit{&kSim,
             "initial_displacement_in = 2.5",
             "command_max_V = 4.2",
             {"6:17: limits.command_max_V: expected a voltage within the output converter's -10..4.2, got 4.5"}}));

INSTANTIATE_TEST_SUITE_P(
    Card, FaultyRig,
    testing::Values(
        Edit{&kCard, "board = \"pci1716\"\n", "", {"14:1: comedi.board: expected a string, got no such key"}},
        Edit{&kCard,
             "heartbeat = \"none\"",
             "",
             {"14:1: comedi.heartbeat: expected a table or \"none\", got no such key"}},
        Edit{&kCard,
             "heartbeat = \"none\"",
             "heartbeat = \"no\"",
             {"20:13: comedi.heartbeat: expected a table or \"none\", got \"no\""}},
        Edit{&kCard,
             "reference = \"diff\"",
             "reference = \"differential\"",
             {"27:13: comedi.feedback.reference: expected \"ground\", \"common\", \"diff\" or \"other\", got "
              "\"differential\""}},
        Edit{&kCard,
             "active = \"low\"",
             "active = 0",
             {"43:10: comedi.enable.active: expected \"high\" or \"low\", got 0"}},
        Edit{&kCard,
             "channel = 4",
             "channel = 32",
             {"42:11: comedi.enable.channel: expected an integer from 0 to 31, got 32"}},
        Edit{&kCard,
             "channel = 1\n",
             "chanel = 1\n",
             {"30:1: comedi.command.channel: expected an integer from 0 to 255, got no such key",
              "32:1: comedi.command.chanel: expected a known key (did you mean \"channel\"?), got an unknown one"}},
        Edit{&kCard,
             "range_max_V = 5.0",
             "range_max_V = 4.0",
             {"6:17: limits.command_max_V: expected a voltage within the output converter's -5..4, got 4.5"}},
        Edit{&kCard,
             "calibration_date = \"2025-11-30\"",
             "calibration_date = \"30.11.2025\"",
             {"23:20: comedi.calibration_date: expected a day as YYYY-MM-DD, got \"30.11.2025\""}},
        Edit{&kCard,
             "feedback_settling_us = 20.0",
             "feedback_settling_us = 100",
             {"19:24: comedi.feedback_settling_us: expected from 0 to 99, got 100"}},
        Edit{&kCard,
             "scale_in_per_V = 0.3",
             "scale_in_per_V = 0",
             {"21:18: comedi.scale_in_per_V: expected a number that is not 0, got 0"}},
        Edit{&kCard,
             "heartbeat = \"none\"",
             "heartbeat = { subdevice = 3, channel = 4, active = \"high\" }",
             {"20:40: comedi.heartbeat.channel: expected another line than enable, got 4"}},
        Edit{&kCard,
             "scale_in_per_V = 0.3",
             "scale_mm_per_V = 0.3",
             {"21:18: comedi.scale_mm_per_V: the sensor would show 2.78189..3.01811 in, which does not hold the travel "
              "0.2..5.5 in, and with 25.4 times this scale it does: is the number in inches (scale_in_per_V)?"}},
        Edit{&kCard,
             "scale_in_per_V = 0.3",
             "scale_in_per_V = 0.2",
             {"9:17: limits.travel_min_in: expected a displacement that the sensor can show, 0.9..4.9 in, "
              "got 0.2",
              "10:17: limits.travel_max_in: expected a displacement that the sensor can show, 0.9..4.9 in, "
              "got 5.5"}}));

}  // namespace
}  // namespace eha::config
