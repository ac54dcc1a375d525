// SPDX-License-Identifier: GPL-3.0-or-later
// What run.json says of an experiment of each kind, and of a rig file that leaves out what it may.
#include "daemon/record/config_json.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"

namespace eha::record {
namespace {

using Json = nlohmann::ordered_json;

Json recorded(config::ExperimentKind kind) {
  config::ExperimentConfig experiment;
  experiment.name = "test";
  experiment.kind = std::move(kind);
  return to_json(experiment);
}

std::vector<std::string> members_of(const Json& json) {
  std::vector<std::string> names;
  for (const auto& [name, value] : json.items()) names.push_back(name);
  return names;
}

TEST(ConfigJson, HasTheSameMembersForEveryKindOfExperiment) {
  const std::vector<std::string> members = {
      "name",        "excitation", "place_in",       "way_back",        "characterises",    "track",
      "start_in",    "hold",       "precision",      "controller_file", "controller_model", "duration_s",
      "repetitions", "record",     "identification", "models",          "acceptance",       "text"};
  EXPECT_EQ(members_of(recorded(config::Played{})), members);
  EXPECT_EQ(members_of(recorded(config::Placing{})), members);
  EXPECT_EQ(members_of(recorded(config::SheetRun{})), members);
  EXPECT_EQ(members_of(recorded(config::Tracking{})), members);
}

TEST(ConfigJson, SaysOfEachKindWhatItPlays) {
  const Json played = recorded(
      config::Played{.start = config::Place{2.5}, .hold = config::Hold{}, .precision = config::Precision{3.0}});
  EXPECT_EQ(played.at("excitation").at("offset_V"), 0.0);
  EXPECT_EQ(played.at("start_in"), 2.5);
  EXPECT_EQ(played.at("hold"), (Json{{"gain_V_per_in", nullptr}}));
  EXPECT_EQ(played.at("precision"), (Json{{"gain_percent", 3.0}}));
  EXPECT_TRUE(played.at("place_in").is_null() && played.at("track").is_null());

  const Json placing = recorded(config::Placing{.place = {.displacement_in = 3.0}, .brings_back = true});
  EXPECT_EQ(placing.at("place_in"), 3.0);
  EXPECT_EQ(placing.at("way_back"), true);
  EXPECT_TRUE(placing.at("excitation").is_null());

  const Json sheet = recorded(config::SheetRun{.start = config::Place{1.5}});
  EXPECT_EQ(sheet.at("characterises"), true);
  EXPECT_EQ(sheet.at("start_in"), 1.5);

  config::Tracking tracking;
  tracking.track.controller.name = "axis";
  EXPECT_EQ(recorded(tracking).at("track"), "axis");
}

TEST(ConfigJson, WritesAnAbsentLimitAsNull) {
  const Json experiment = recorded(config::Played{});
  EXPECT_TRUE(experiment.at("acceptance").at("max_abs_error_in").is_null());
  EXPECT_TRUE(experiment.at("record").at("input_before_V").is_null());
}

TEST(ConfigJson, LeavesOutOfARigWhatItsFileLeavesOut) {
  config::RigConfig rig;
  rig.name = "bench";
  Json json = to_json(rig);
  EXPECT_TRUE(json.at("following").is_null() && json.at("sensor").is_null());
  EXPECT_FALSE(json.contains("units") || json.at("limits").contains("closed_loop_max_V"));
  EXPECT_EQ(json.at("limits").at("command_min_V"), -5.0);
  EXPECT_EQ(json.at("realtime").at("priority"), 80);
  EXPECT_TRUE(json.at("realtime").at("cpu").is_null());

  rig.units = "mm";
  rig.limits.closed_loop_max_V = 1.5;
  rig.limits.sensor = config::SensorBand{.valid_min_V = 0.5, .valid_max_V = 9.5};
  json = to_json(rig);
  EXPECT_EQ(json.at("units"), "mm");
  EXPECT_EQ(json.at("limits").at("closed_loop_max_V"), 1.5);
  EXPECT_EQ(json.at("sensor").at("open_circuit_V"), "unknown");
}

}  // namespace
}  // namespace eha::record
