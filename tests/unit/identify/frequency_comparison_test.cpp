// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/frequency_comparison.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "tests/unit/identify/lag_source.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::identify {
namespace {

using eha::test::content_of;
using eha::test::TemporaryFolder;
using test::discarding;
using test::kTones;
using test::realised_source_of;
using test::source_of;
using test::the_plant;

TEST(FrequencyResponseOf, UsesThePeriodsOfTheTonesWithinOneRepetition) {
  std::vector<std::string> notes;
  const auto measured = frequency_response_of(source_of(30.0, 1, kTones), discarding(5.0), notes);
  ASSERT_TRUE(measured.has_value());
  EXPECT_EQ(measured->periods.length, 1000U);
  EXPECT_EQ(measured->periods.count, 2U);
  EXPECT_EQ(measured->lines.size(), 2U);
}

TEST(FrequencyResponseOf, UsesTheRepetitionWhereTheTonesJumpAtItsEnd) {
  std::vector<std::string> notes;
  const auto measured = frequency_response_of(source_of(15.0, 3, kTones), discarding(5.0), notes);
  ASSERT_TRUE(measured.has_value());
  EXPECT_EQ(measured->periods.length, 1500U);
  EXPECT_EQ(measured->periods.count, 2U);
}

TEST(FrequencyResponseOf, TakesThePeriodsWithinTheLastRepetitionWhereItCutsATone) {
  std::vector<std::string> notes;
  const std::vector<ident::Tone> tones{{0.05, 1.0, 1.8}, {0.2, 1.0, 1.9}, {0.65, 1.0, 4.2}};
  const auto measured = frequency_response_of(source_of(50.0, 3, tones), discarding(10.0), notes);
  ASSERT_TRUE(measured.has_value());
  ASSERT_EQ(measured->lines.size(), 3U) << "none is left out";
  EXPECT_EQ(measured->periods.length, 2000U);
  EXPECT_EQ(measured->periods.first, 11000U);
  EXPECT_TRUE(notes.empty());
  for (const ident::LineResponse& line : measured->lines) {
    const std::complex<double> lag = 2.0 / std::complex<double>(1.0, 0.1 * 2.0 * std::numbers::pi * line.frequency_Hz);
    EXPECT_NEAR(std::abs(line.response / lag - 1.0), 0.0, 1e-3) << line.frequency_Hz;
  }
}

TEST(FrequencyResponseOf, NamesTheTonesThatItLeavesOut) {
  std::vector<std::string> notes;
  const std::vector<ident::Tone> tones{{0.05, 1.0, 1.8}, {0.2, 1.0, 1.9}, {0.65, 1.0, 4.2}};
  const auto measured = frequency_response_of(source_of(50.0, 3, tones), discarding(12.0), notes);
  ASSERT_TRUE(measured.has_value());
  EXPECT_EQ(measured->lines.size(), 1U);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0],
            "the measured frequency response lacks 0.05, 0.65 Hz: a repetition of 50 s holds no whole number of "
            "periods of each; "
            "with a duration_s of 60 it would");
}

TEST(FrequencyResponseOf, TakesNoPeriodsAcrossAJumpOfTheTable) {
  std::vector<std::string> notes;
  Source source = source_of(25.0, 2, kTones);
  source.record.input.conservativeResize(4500);
  source.record.output.conservativeResize(4500);
  EXPECT_FALSE(frequency_response_of(source, discarding(0.0), notes).has_value());
  EXPECT_EQ(notes.at(0), "no frequency response: the record holds no two periods of the excited lines");
}

TEST(FrequencyResponseOf, MeasuresTheRealisationsOfTheLastRepetition) {
  std::vector<std::string> notes;
  const Source source = realised_source_of(4, 2);
  const auto measured = frequency_response_of(source, discarding(5.0), notes);
  ASSERT_TRUE(measured.has_value()) << notes.at(0);
  EXPECT_EQ(measured->realisations, 4U);
  EXPECT_EQ(measured->periods.first, 13000U);
  EXPECT_EQ(measured->periods.length, 1000U);
  // Within one repetition those are left out that begin within the discarded time.
  const auto later = frequency_response_of(realised_source_of(4, 1), discarding(11.0), notes);
  ASSERT_TRUE(later.has_value());
  EXPECT_EQ(later->realisations, 3U);
  EXPECT_EQ(later->periods.first, 4000U);
}

TEST(FrequencyResponseOf, IsNoneWithoutAnExperimentOrTwoPeriods) {
  std::vector<std::string> notes;
  Source source = source_of(30.0, 1, kTones);
  EXPECT_FALSE(frequency_response_of(source, discarding(15.0), notes).has_value());
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0].rfind("no frequency response: ", 0), 0U) << notes[0];
  source.experiment.reset();
  EXPECT_FALSE(frequency_response_of(source, discarding(0.0), notes).has_value());
  EXPECT_EQ(notes.size(), 1U);
}

TEST(FrequencyComparison, IsWrittenAsOneRowForEachLine) {
  std::vector<std::string> notes;
  const TemporaryFolder folder;
  const auto measured = frequency_response_of(source_of(30.0, 1, kTones), discarding(10.0), notes);
  ASSERT_TRUE(measured.has_value());
  const auto path = write_frequency_response(*measured, the_plant(), folder.path());
  const std::string text = content_of(path);
  EXPECT_EQ(path.filename(), "frequency_response.csv");
  EXPECT_EQ(text.rfind("frequency_Hz,gain,gain_dB,phase_deg,std,even_distortion_dB,odd_distortion_dB,noise_dB,"
                       "distortion_dB,odd_distortion_Hz,io_gain_dB,io_gain_std_dB,"
                       "io_phase_deg,io_phase_std_deg\n0.1,",
                       0),
            0U)
      << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
}

}  // namespace
}  // namespace eha::identify
