// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/sheet_beside.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>

#include "tests/unit/temporary_folder.hpp"

namespace eha::record {
namespace {

/// A run's manifest, of a rig of that name, scale and [sim].
std::string manifest_on(const std::string& name, double scale, const std::string& sim) {
  return fmt::format(R"({{"schema": "eha-run/1", "outcome": "completed", "sample_period_s": 0.001,
      "rig": {{"name": "{}", "calibration": {{"scale_in_per_V": {}, "offset_in": 0}}, "sim": {}}}}})",
                     name, scale, sim);
}

TEST(NewestSheetRun, IsOfTheSameRigNotOfOneOfItsName) {
  const test::TemporaryFolder folder;
  const auto run = [&](const char* time, const std::string& manifest, bool has_sheet) {
    const std::string name = fmt::format("2026{}T000000Z-a", time);
    std::filesystem::create_directories(folder.path() / name);
    folder.write(name + "/run.json", manifest);
    if (has_sheet) folder.write(name + "/" + std::string(kSheetFile), "{}");
    return folder.path() / name;
  };
  const std::string plant = R"({"valve_null_offset_V": 0.2, "seed": 1, "initial_displacement_in": 2.95})";
  const auto own = run("0101", manifest_on("rig", 0.6, plant), true);
  run("0102", manifest_on("rig", 0.6, R"({"valve_null_offset_V": 0.5, "seed": 1})"), true);
  run("0104", manifest_on("other", 0.6, plant), true);
  const auto later = run("0105", manifest_on("rig", 0.6, R"({"valve_null_offset_V": 0.2, "seed": 7})"), false);
  EXPECT_EQ(newest_sheet_run(later), own);
  const auto newer = run("0106", manifest_on("rig", 0.3, plant), true);  // another calibration of the same rig
  EXPECT_EQ(newest_sheet_run(later), newer);
  EXPECT_EQ(newest_sheet_run(run("0107", manifest_on("alone", 0.6, plant), false)), std::nullopt);
}

TEST(ValveIn, HasNullAndDeadBandAndTheGainsThatTheSheetKnows) {
  const test::TemporaryFolder folder;
  EXPECT_FALSE(valve_in(folder.path())) << "no sheet";
  folder.write(std::string(kSheetFile), R"({"null_V": {"value": -0.2}})");
  EXPECT_FALSE(valve_in(folder.path()));
  folder.write(std::string(kSheetFile), R"({"null_V": {"value": -0.2}, "dead_band_V": {"value": 0.15}})");
  const auto valve = valve_in(folder.path());
  ASSERT_TRUE(valve.has_value());
  EXPECT_EQ(valve->zone.null_V, -0.2);
  EXPECT_EQ(valve->zone.dead_band_V, 0.15);
  EXPECT_FALSE(valve->gains.has_value());
  folder.write(std::string(kSheetFile), R"({"null_V": {"value": -0.2}, "dead_band_V": {"value": 0.15},
      "gain_positive_in_per_V_s": {"value": 1.2}, "gain_negative_in_per_V_s": {"value": 1.1}})");
  EXPECT_EQ(valve_in(folder.path())->gains, std::pair(1.2, 1.1));
}

}  // namespace
}  // namespace eha::record
