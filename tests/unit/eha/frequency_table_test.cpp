// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/frequency_table.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "daemon/identify/frequency_comparison.hpp"
#include "tests/unit/identify/lag_source.hpp"

namespace eha::cli {
namespace {

using identify::frequency_response_of;
using identify::test::discarding;
using identify::test::kTones;
using identify::test::source_of;
using identify::test::the_plant;

TEST(FrequencyTable, ShowsTheSameGainAndPhaseForThePlantAndItsRecord) {
  std::vector<std::string> notes;
  const auto measured = frequency_response_of(source_of(30.0, 1, kTones), discarding(10.0), notes);
  ASSERT_TRUE(measured.has_value());
  // 2 / (1 + 0.1 j 2 pi 0.5): 5.61 dB, -17.4 degrees.
  const std::string table = frequency_table(*measured, the_plant());
  EXPECT_NE(table.find("5.61"), std::string::npos) << table;
  EXPECT_NE(table.find("-17.4"), std::string::npos) << table;
  const nlohmann::json json = frequency_json(*measured, the_plant());
  ASSERT_EQ(json.at("lines").size(), 2U);
  for (const auto& line : json.at("lines")) {
    const auto& model = line.at("models").at("io");
    EXPECT_NEAR(line.at("gain_dB").get<double>(), model.at("gain_dB").get<double>(), 0.01);
    EXPECT_NEAR(line.at("phase_deg").get<double>(), model.at("phase_deg").get<double>(), 0.1);
    EXPECT_GT(model.at("gain_std_dB").get<double>(), 0.0);
    EXPECT_LT(model.at("gain_std_dB").get<double>(), 0.1);
  }
  EXPECT_TRUE(json.at("lines")[0].at("odd_distortion_dB").is_number());  // the third harmonic is silent
}

TEST(FrequencyTable, ShowsNoiseAndDistortionOfSeveralRealisations) {
  std::vector<std::string> notes;
  identify::Source source = identify::test::realised_source_of(4, 1);
  for (double& y : source.record.output) y += 0.1 * y * y;
  const auto measured = frequency_response_of(source, discarding(0.0), notes);
  ASSERT_TRUE(measured.has_value());
  const std::string table = frequency_table(*measured, the_plant());
  EXPECT_NE(table.find("4 realisations; below the output: noise"), std::string::npos) << table;
  EXPECT_NE(table.find("dist. dB"), std::string::npos) << table;
  EXPECT_NE(table.find("by noise and distortion"), std::string::npos) << table;
  const nlohmann::json json = frequency_json(*measured, the_plant());
  EXPECT_EQ(json.at("realisations"), 4);
  EXPECT_GT(json.at("levels").at("even_distortion_dB").get<double>(), -40.0);
  EXPECT_FALSE(frequency_json(*frequency_response_of(source_of(30.0, 1, kTones), discarding(10.0), notes), {})
                   .contains("levels"));
}

TEST(FrequencyTable, ThinsOutManyLinesAndSaysSo) {
  std::vector<std::string> notes;
  std::vector<ident::Tone> tones;
  for (int k = 1; k <= 100; ++k) tones.push_back({0.1 * k, 0.05, 0.1 * k * k});
  const auto measured = frequency_response_of(source_of(30.0, 1, tones), discarding(10.0), notes);
  ASSERT_TRUE(measured.has_value());
  EXPECT_EQ(measured->lines.size(), 100U);
  EXPECT_NE(frequency_table(*measured, {}).find("one line in 3 of 100"), std::string::npos);
}

}  // namespace
}  // namespace eha::cli
