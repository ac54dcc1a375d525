// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/frequency_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "ident/excitation/excitation.hpp"
#include "ident/fractional/simulate.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::cli {
namespace {

using test::content_of;
using test::TemporaryFolder;

constexpr double kStep_s = 0.01;
const ident::TransferFunction kLag{{{2.0, 0.0}}, {{0.1, 1.0}, {1.0, 0.0}}, 0.0};

/// A lag driven by tones whose common period is 10 s, played for `duration_s`, so often.
Source source_of(double duration_s, int repetitions, const std::vector<ident::Tone>& tones) {
  Source source;
  source.name = "test";
  source.record.step_s = kStep_s;
  source.experiment.emplace();
  source.experiment->excitation.kind = ident::Multisine{tones};
  source.experiment->duration_s = duration_s;
  source.repetition_samples = static_cast<std::size_t>(std::lround(duration_s / kStep_s));
  source.record.input =
      ident::excitation(source.experiment->excitation, kStep_s, source.repetition_samples).replicate(repetitions, 1);
  source.record.output = ident::simulate(kLag, source.record.input, kStep_s);
  return source;
}

const std::vector<ident::Tone> kTones{{0.1, 1.0, 0.4}, {0.5, 0.5, 1.0}};

ident::FitOptions discarding(double seconds) {
  ident::FitOptions options;
  options.discard_s = seconds;
  return options;
}

/// What a fit would have left: the plant itself.
std::vector<IdentifiedModel> the_plant() {
  std::vector<IdentifiedModel> models(1);
  models[0].result.model.name = "io";
  models[0].result.model.transfer_function = kLag;
  models[0].result.covariance = {{ident::numerator_key(0, 1), ident::coefficient_key(0)},
                                 1e-6 * Eigen::MatrixXd::Identity(2, 2)};
  return models;
}

TEST(FrequencyResponseOf, UsesThePeriodsOfTheTonesWithinOneRepetition) {
  const auto measured = frequency_response_of(source_of(30.0, 1, kTones), discarding(5.0), Console({}));
  ASSERT_TRUE(measured.has_value());
  EXPECT_EQ(measured->periods.length, 1000U);
  EXPECT_EQ(measured->periods.count, 2U);
  EXPECT_EQ(measured->lines.size(), 2U);
}

TEST(FrequencyResponseOf, UsesTheRepetitionWhereTheTonesJumpAtItsEnd) {
  const auto measured = frequency_response_of(source_of(15.0, 3, kTones), discarding(5.0), Console({}));
  ASSERT_TRUE(measured.has_value());
  EXPECT_EQ(measured->periods.length, 1500U);
  EXPECT_EQ(measured->periods.count, 2U);
}

TEST(FrequencyResponseOf, IsNoneWithoutAnExperimentOrTwoPeriods) {
  Source source = source_of(30.0, 1, kTones);
  EXPECT_FALSE(frequency_response_of(source, discarding(15.0), Console({.quiet = true})).has_value());
  source.experiment.reset();
  EXPECT_FALSE(frequency_response_of(source, discarding(0.0), Console({})).has_value());
}

TEST(FrequencyTable, ShowsTheSameGainAndPhaseForThePlantAndItsRecord) {
  const auto measured = frequency_response_of(source_of(30.0, 1, kTones), discarding(10.0), Console({}));
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

TEST(FrequencyTable, ThinsOutManyLinesAndSaysSo) {
  std::vector<ident::Tone> tones;
  for (int k = 1; k <= 100; ++k) tones.push_back({0.1 * k, 0.05, 0.1 * k * k});
  const auto measured = frequency_response_of(source_of(30.0, 1, tones), discarding(10.0), Console({}));
  ASSERT_TRUE(measured.has_value());
  EXPECT_EQ(measured->lines.size(), 100U);
  EXPECT_NE(frequency_table(*measured, {}).find("one line in 3 of 100"), std::string::npos);
}

TEST(FrequencyTable, IsWrittenAsOneRowForEachLine) {
  const TemporaryFolder folder;
  const auto measured = frequency_response_of(source_of(30.0, 1, kTones), discarding(10.0), Console({}));
  ASSERT_TRUE(measured.has_value());
  const auto path = write_frequency_response(*measured, the_plant(), folder.path());
  const std::string text = content_of(path);
  EXPECT_EQ(path.filename(), "frequency_response.csv");
  EXPECT_EQ(
      text.rfind(
          "frequency_Hz,gain,gain_dB,phase_deg,std,even_distortion_dB,odd_distortion_dB,io_gain_dB,io_gain_std_dB,"
          "io_phase_deg,io_phase_std_deg\n0.1,",
          0),
      0U)
      << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
}

}  // namespace
}  // namespace eha::cli
