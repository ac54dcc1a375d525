// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "tests/system/drawn_rigs.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

using nlohmann::json;

double between(double low, double high, std::mt19937_64& draw) {
  return low + (high - low) * static_cast<double>(draw() >> 11) * 0x1p-53;
}

class PerturbedRig : public testing::TestWithParam<int> {};

TEST_P(PerturbedRig, IsRecommendedAModelBehindItsValve) {
  std::mt19937_64 draw(static_cast<std::uint64_t>(GetParam()));
  const double null_V = -between(0.1, 0.3, draw);
  const double dead_band_V = between(0.1, 0.2, draw);
  const double coulomb_N = between(80.0, 160.0, draw);
  std::string rig = content_of(source_file("config/rigs/sim.toml"));
  rig = with_value(rig, "valve_null_offset_V", -null_V);
  rig = with_value(rig, "valve_dead_band_V", dead_band_V);
  rig = with_value(rig, "rod_mm", between(18.0, 22.0, draw));
  rig = with_value(rig, "coulomb_friction_N", coulomb_N);
  rig = with_value(rig, "static_friction_N", coulomb_N * between(1.2, 1.6, draw));
  rig = with_value(rig, "moving_mass_kg", between(15.0, 30.0, draw));
  rig = with_value(rig, "bulk_modulus_bar", between(5000.0, 9000.0, draw));
  // What the rig's owner would have measured of this valve.
  rig = with_value(rig, "null_V", null_V);
  rig = with_value(rig, "dead_band_V", dead_band_V + 0.05);
  const TemporaryFolder folder;
  folder.write("rig.toml", rig);
  const Ended ended =
      run_eha({"run", source_file("config/experiments/paper.toml"), "--local", "--fast", "--rig", "rig.toml", "--json"},
              folder.path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  const json document = json::parse(ended.out);
  const json& recommendation = document.at("recommendation");
  bool is_found = false;
  for (const json& model : document.at("models")) {
    if (model.at("name") != recommendation.at("model")) continue;
    is_found = true;
    ASSERT_TRUE(model.contains("input_map")) << recommendation;
    EXPECT_NEAR(model.at("input_map").at("null").get<double>(), null_V, 0.02);
    EXPECT_NEAR(model.at("input_map").at("dead_band").get<double>(), dead_band_V, 0.02);
    EXPECT_GE(model.at("validation").at("fit_percent").get<double>(), 99.5);
    EXPECT_TRUE(model.at("verdict").at("accepted").get<bool>());
  }
  EXPECT_TRUE(is_found) << recommendation;
  // What the record does not identify is not accepted: no free order of an accepted model has a standard error above
  // 0.15, and no free coefficient an interval that holds 0.
  for (const json& model : document.at("models")) {
    if (!model.at("verdict").at("accepted").get<bool>()) continue;
    for (const json& parameter : model.at("parameters")) {
      const std::string name = parameter.at("name");
      if (parameter.at("fixed").get<bool>()) continue;
      if (name[0] == 'n' && name != "null" && name != "negative_gain_ratio") {
        EXPECT_LE(parameter.at("std").get<double>(), 0.15) << model.at("name") << " " << name;
      }
      if (name[0] == 'a' || name == "K") {
        EXPECT_GT(parameter.at("lower95").get<double>() * parameter.at("upper95").get<double>(), 0.0)
            << model.at("name") << " " << name;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Ten, PerturbedRig, testing::Range(1, 11));

}  // namespace
}  // namespace eha::test
