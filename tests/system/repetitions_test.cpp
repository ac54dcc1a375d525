// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kThreeTimes = R"(schema = 1
name = "three"
duration_s = 10.0
repetitions = 3
[excitation]
kind = "odd_random_multisine"
amplitude_V = 3.0
offset_V = -0.2
frequency_min_Hz = 0.1
frequency_max_Hz = 1.0
[record]
discard_s = 5.0
decimation = 40
split = 0.5
[[model]]
name = "io"
structure = "terms"
denominator = [{ order = 1.0 }, { order = 0.0, coefficient = 0.0 }]
[acceptance]
min_validation_r2_percent = 50.0
)";

TEST(Repetitions, GiveAFrequencyResponseAndCrossValidation) {
  const TemporaryFolder folder;
  folder.write("three.toml", kThreeTimes);
  const Ended run =
      run_eha({"run", "three.toml", "--local", "--fast", "--rig", source_file("config/rigs/sim.toml"), "--json"},
              folder.path());
  ASSERT_EQ(run.code, 0) << run.err;
  const json first = json::parse(run.out);
  const json& response = first.at("frequency_response");
  EXPECT_EQ(response.at("periods"), 2);
  EXPECT_EQ(response.at("period_samples"), 10000);
  for (const json& line : response.at("lines")) {
    EXPECT_TRUE(line.at("even_distortion_dB").is_number()) << line;
    EXPECT_TRUE(line.at("models").contains("io")) << line;
  }
  const std::string run_name = first.at("run").get<std::string>();
  EXPECT_TRUE(fs::is_regular_file(folder.path() / run_name / "frequency_response.csv"));
  const json manifest = json::parse(content_of(folder.path() / run_name / "run.json"));
  EXPECT_NE(manifest.at("files").dump().find("frequency_response.csv"), std::string::npos);

  const Ended fit = run_eha({"fit", run_name, "--cross-validate", "--json", "-o", "models"}, folder.path());
  ASSERT_EQ(fit.code, 0) << fit.err;
  const json again = json::parse(fit.out);
  EXPECT_EQ(again.at("frequency_response").at("lines"), response.at("lines"));
  ASSERT_EQ(again.at("cross_validation").size(), 3U);
  for (const json& model : again.at("cross_validation")) {
    EXPECT_GT(model.at("others_r2_percent_offset_reestimated").get<double>(), 50.0) << model;
  }
  EXPECT_TRUE(fs::is_regular_file(folder.path() / "models" / "frequency_response.csv"));
  // The estimating half is that of the whole record after the discarded time, not of one repetition: 12.5 s of 25.
  EXPECT_NEAR(again.at("models").at(0).at("estimation").at("samples").get<double>(), 312.0, 8.0);
}

}  // namespace
}  // namespace eha::test
