// SPDX-License-Identifier: GPL-3.0-or-later
// Measured records whose licences do not let them be kept in the project; tests skip where they are absent.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/system/program.hpp"
#include "tests/unit/shared_data.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

using nlohmann::json;

/// The first model of `eha fit FILE ...`.
/// @param remark  the only warning that the record deserves; empty: none
json fitted(const std::filesystem::path& file, std::vector<std::string> options, const std::string& remark = {}) {
  const TemporaryFolder folder;
  std::vector<std::string> arguments{"fit", file.string(), "--json"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const Ended ended = run_eha(arguments, folder.path());
  const std::size_t warned = ended.err.find("warning:");
  if (remark.empty()) {
    EXPECT_EQ(warned, std::string::npos) << ended.err;
  } else {
    EXPECT_NE(ended.err.find(remark, warned), std::string::npos) << ended.err;
  }
  EXPECT_EQ(ended.err.find("error:"), std::string::npos) << ended.err;
  return json::parse(ended.out).at("models").at(0);
}

double fit_percent(const json& score) { return score.at("fit_percent").get<double>(); }

TEST(MeasuredRecord, OfAServohydraulicActuatorIsFittedByTwoPoles) {
  const auto file = shared("data/servohydraulic_mts.csv");
  EHA_REQUIRE_SHARED(file);
  EXPECT_GE(fit_percent(fitted(file, {"--model", "io", "--split", "1"}).at("estimation")), 96.5);
  EXPECT_GE(fit_percent(fitted(file, {"--model", "io", "--split", "1", "--delay", "free"}).at("estimation")), 96.7);
}

TEST(MeasuredRecord, OfAHairDryerIsFittedByThreePolesAZeroAndADelay) {
  const auto file = shared("data/hair_dryer.csv");
  EHA_REQUIRE_SHARED(file);
  const json model = fitted(file, {"--model", "io", "--poles", "3", "--zeros", "1", "--delay", "free"});
  EXPECT_GE(fit_percent(model.at("estimation")), 89.5);
  // The optimum is nearly an integrator, whose offset drifts on; the offset estimated anew shows the dynamics.
  EXPECT_GE(fit_percent(model.at("validation")), 82.0);
  EXPECT_GE(fit_percent(model.at("validation").at("offset_reestimated")), 91.0);
}

TEST(MeasuredRecord, OfAnActuatorInClosedLoopGetsAVerdictWithReasons) {
  const auto file = shared("data/eha_pump.csv");
  EHA_REQUIRE_SHARED(file);
  const json model = fitted(file, {"--model", "io"},
                            "its least value: the sensor is at its end, a rod stands, or the output has settled");
  EXPECT_FALSE(model.at("verdict").at("reasons").empty());
}

}  // namespace
}  // namespace eha::test
