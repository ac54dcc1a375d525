// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/live_response.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "core/error.hpp"
#include "daemon/record/journal.hpp"
#include "ident/signal/frequency_response.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::web {
namespace {

using Json = nlohmann::ordered_json;
using acquisition::TickRecord;

constexpr double kStep_s = 0.001;
constexpr std::size_t kPeriod = 2000;

/// Tones of 0.5, 1.5 and 2.5 Hz, repeated.
record::RunHeader header_of(std::size_t repetitions, double discard_s = 1.0) {
  record::RunHeader header;
  header.sample_period_s = kStep_s;
  header.samples_per_repetition = kPeriod;
  header.repetitions = repetitions;
  header.discard_s = discard_s;
  header.experiment_text = R"(schema = 1
name = "live"
duration_s = 2.0
repetitions = )" + std::to_string(repetitions) +
                           R"(
[excitation]
kind = "multisine"
tones = [
  { frequency_Hz = 0.5, amplitude_V = 1.0 },
  { frequency_Hz = 1.5, amplitude_V = 1.0, phase_rad = 1.0 },
  { frequency_Hz = 2.5, amplitude_V = 1.0, phase_rad = 2.0 },
]
[record]
discard_s = )" + std::to_string(discard_s) +
                           R"(
decimation = 40
[[model]]
name = "io"
structure = "io"
[acceptance]
min_validation_r2_percent = 90.0
)";
  return header;
}

/// A lag of 0.1 s, driven by the tones: exact for a held input.
ident::Record record_of(std::size_t rows, double noise_in) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise(0.0, 1.0);
  const double keeps = std::exp(-kStep_s / 0.1);
  ident::Record record;
  record.step_s = kStep_s;
  record.input.resize(static_cast<Eigen::Index>(rows));
  record.output.resize(static_cast<Eigen::Index>(rows));
  double y = 0.0;
  for (Eigen::Index k = 0; k < record.input.size(); ++k) {
    const double t = 2.0 * std::numbers::pi * static_cast<double>(k) * kStep_s;
    record.input[k] = std::sin(0.5 * t) + std::sin(1.5 * t + 1.0) + std::sin(2.5 * t + 2.0);
    record.output[k] = y + noise_in * noise(random);
    y = keeps * y + (1.0 - keeps) * record.input[k];
  }
  return record;
}

/// The journal of a run that is on: ramps before it, no end.
std::filesystem::path journal_of(const ident::Record& record, const test::TemporaryFolder& folder) {
  const std::filesystem::path path = folder.path() / "raw.ehalog";
  std::filesystem::remove(path);
  record::JournalWriter writer(path, Json::object(), 100);
  constexpr std::uint32_t kRamp = 300;
  std::vector<TickRecord> ticks(static_cast<std::size_t>(record.input.size()) + kRamp);
  for (std::uint32_t i = 0; i < ticks.size(); ++i) {
    TickRecord& tick = ticks[i];
    tick.sequence = i;
    tick.scheduled_ns = std::int64_t{i} * 1'000'000;
    tick.state = i < kRamp ? acquisition::State::ramp_in : acquisition::State::running;
    if (i < kRamp) continue;
    tick.applied_V = record.input[i - kRamp];
    tick.displacement_in = record.output[i - kRamp];
  }
  writer.append(ticks);
  return path;
}

TEST(LiveResponse, TellsTheRodFromTheValvesDeadBand) {
  // The same lag behind a dead band: response over valve is the lag's alone, whatever the amplitude.
  const test::TemporaryFolder folder;
  ident::Record behind = record_of(6 * kPeriod, 0.0);
  const PeriodPlan without = plan_periods(header_of(6), "test");
  EXPECT_FALSE(without.valve.has_value()) << "no rig file, no valve";
  PeriodPlan plan = without;
  plan.valve = ident::ValveMap{.null = 0.1, .dead_band = 0.4, .negative_gain_ratio = 0.8};
  const LiveResponse lag = measure_live_response(journal_of(behind, folder), without);
  EXPECT_TRUE(lag.valve.empty());
  const Eigen::VectorXd passed = ident::mapped(*plan.valve, behind.input);
  const double keeps = std::exp(-kStep_s / 0.1);
  double y = 0.0;
  for (Eigen::Index k = 0; k < passed.size(); ++k) {
    behind.output[k] = y;
    y = keeps * y + (1.0 - keeps) * passed[k];
  }
  const LiveResponse live = measure_live_response(journal_of(behind, folder), plan);
  ASSERT_EQ(live.valve.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GT(std::abs(live.valve[i] - 1.0), 0.1) << "the valve takes a share";
    const std::complex<double> rod = live.lines[i].response / live.valve[i];
    // The valve's harmonics above the thinned rate fold back onto the lines.
    EXPECT_LT(std::abs(rod / lag.lines[i].response - 1.0), 0.01) << live.lines[i].frequency_Hz;
  }
  const Json answer = Json::parse(describe("run", plan, live, live.rows));
  EXPECT_NEAR(answer.at("lines")[0].at("valve_phase_deg").get<double>(),
              std::arg(live.valve[0]) * 180.0 / std::numbers::pi, 1e-9);
}

TEST(LiveResponse, IsThatOfTheWholeRecordToTheStopbandOfTheFilter) {
  const test::TemporaryFolder folder;
  const ident::Record record = record_of(6 * kPeriod, 0.0);
  const PeriodPlan plan = plan_periods(header_of(6), "test");
  EXPECT_EQ(plan.period, kPeriod);
  EXPECT_GT(plan.thinning, 10U);
  const LiveResponse live = measure_live_response(journal_of(record, folder), plan);
  EXPECT_EQ(live.rows, 6 * kPeriod);
  EXPECT_EQ(live.periods, 5U);
  const ident::FrequencyResponse whole =
      ident::measure_frequency_response(record, ident::last_periods(6 * kPeriod, kPeriod, 1000), plan.lines_Hz);
  ASSERT_EQ(live.lines.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(live.lines[i].frequency_Hz, whole.lines[i].frequency_Hz);
    // What is left of the lag's transient, exp(-10) after the discarded second, falls differently on both.
    EXPECT_LT(std::abs(live.lines[i].response - whole.lines[i].response), 1e-4 * std::abs(whole.lines[i].response));
    const std::complex<double> lag =
        1.0 / std::complex<double>(1.0, 0.2 * std::numbers::pi * whole.lines[i].frequency_Hz);
    EXPECT_LT(std::abs(live.lines[i].response - lag), 1e-4 * std::abs(lag));
  }
}

TEST(LiveResponse, HasTheSameStandardErrorsWithNoise) {
  const test::TemporaryFolder folder;
  const ident::Record record = record_of(20 * kPeriod, 0.05);
  const PeriodPlan plan = plan_periods(header_of(20), "test");
  const LiveResponse live = measure_live_response(journal_of(record, folder), plan);
  // The same periods: those that the filter leaves.
  const std::size_t rows = 20 * kPeriod - 8 * plan.thinning;
  const ident::FrequencyResponse whole =
      ident::measure_frequency_response(record, ident::last_periods(rows, kPeriod, 1000), plan.lines_Hz);
  ASSERT_EQ(live.lines.size(), 3U);
  EXPECT_EQ(live.periods, whole.periods.count);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT(std::abs(live.lines[i].response - whole.lines[i].response), whole.lines[i].std);
    EXPECT_NEAR(live.lines[i].std / whole.lines[i].std, 1.0, 0.1);
    EXPECT_NEAR(live.lines[i].noise_dB, whole.lines[i].noise_dB, 1.0);
  }
}

TEST(LiveResponse, SaysHowLongItTakesUntilTwoPeriodsAreThere) {
  const test::TemporaryFolder folder;
  const PeriodPlan plan = plan_periods(header_of(6), "test");
  const LiveResponse live = measure_live_response(journal_of(record_of(3500, 0.0), folder), plan);
  EXPECT_EQ(live.periods, 0U);
  EXPECT_TRUE(live.lines.empty());
  const Json said = Json::parse(describe("run", plan, live, 0));
  EXPECT_EQ(said.at("rows"), 3500);
  EXPECT_EQ(said.at("rows_total"), 12000);
  EXPECT_TRUE(said.at("usable_band_Hz").is_null());
  const std::string unknown = said.at("unknown");
  EXPECT_NE(unknown.find("two periods of 2 s after the discarded 1 s; 2 s more"), std::string::npos) << unknown;
}

TEST(LiveResponse, IsKnownFromExactlyTwoPeriodsAfterTheDiscardedTime) {
  const test::TemporaryFolder folder;
  const PeriodPlan plan = plan_periods(header_of(6), "test");
  const std::size_t rows = plan.discard + 2 * plan.period;
  EXPECT_EQ(measure_live_response(journal_of(record_of(rows - 1, 0.0), folder), plan).periods, 0U);
  const LiveResponse live = measure_live_response(journal_of(record_of(rows, 0.0), folder), plan);
  EXPECT_EQ(live.periods, 2U);
  ASSERT_EQ(live.lines.size(), 3U);
  const std::complex<double> lag = 1.0 / std::complex<double>(1.0, 0.2 * std::numbers::pi * 0.5);
  EXPECT_LT(std::abs(live.lines[0].response - lag), 1e-3 * std::abs(lag));
}

TEST(LiveResponse, IsReadFromAJournalWhoseLastBlockIsHalfWritten) {
  const test::TemporaryFolder folder;
  const PeriodPlan plan = plan_periods(header_of(6), "test");
  const std::filesystem::path journal = journal_of(record_of(6 * kPeriod, 0.0), folder);
  std::filesystem::resize_file(journal, std::filesystem::file_size(journal) - 1000);
  const LiveResponse live = measure_live_response(journal, plan);
  EXPECT_EQ(live.rows, 6 * kPeriod - 100);
  EXPECT_EQ(live.lines.size(), 3U);
}

TEST(LiveResponse, NamesTheLinesThatAreNotKnownAndTheBandThatIs) {
  PeriodPlan plan = plan_periods(header_of(6), "test");
  LiveResponse live;
  live.periods = 4;
  for (const double std : {0.5, 0.01, 0.02, 0.2}) {
    ident::LineResponse line;
    line.frequency_Hz = static_cast<double>(live.lines.size() + 1);
    line.response = 1.0;
    line.std = std;
    live.lines.push_back(line);
  }
  live.lines[1].even_distortion_dB = -40.0;
  live.lines[1].odd_distortion_dB = -30.0;
  const Json said = Json::parse(describe("run", plan, live, 9000));
  EXPECT_EQ(said.at("usable_band_Hz"), Json::parse("[2.0, 3.0]"));
  const std::string unknown = said.at("unknown");
  EXPECT_NE(unknown.find("1, 4 Hz"), std::string::npos) << unknown;
  EXPECT_NE(unknown.find("more periods"), std::string::npos) << unknown;
  EXPECT_EQ(said.at("complete_s"), 8.0);
  const Json& lines = said.at("lines");
  EXPECT_NEAR(lines.at(1).at("magnitude_std_dB").get<double>(), 20.0 * std::log10(1.01), 1e-3);
  EXPECT_NEAR(lines.at(1).at("phase_std_deg").get<double>(), 0.573, 1e-3);
  EXPECT_EQ(lines.at(1).at("distortion_dB"), -30.0);
  EXPECT_TRUE(lines.at(0).at("distortion_dB").is_null());
}

TEST(LiveResponse, IsRefusedWhereTheExperimentHasNoTwoEqualPeriods) {
  const test::TemporaryFolder folder;
  PeriodPlan plan = plan_periods(header_of(1), "test");
  EXPECT_EQ(plan.period, 0U) << "one repetition of one period";
  const LiveResponse live = measure_live_response(journal_of(record_of(2000, 0.0), folder), plan);
  EXPECT_NE(live.refusal.find("no two equal periods"), std::string::npos);
  plan.period = 1'000'000;
  plan.rows = 10'000'000;
  plan.thinning = 1;
  EXPECT_NE(measure_live_response("not read", plan).refusal.find("too many"), std::string::npos);
}

TEST(LiveResponse, RefusesAFileThatIsNoJournal) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(
      static_cast<void>(measure_live_response(folder.write("raw.ehalog", "text"), plan_periods(header_of(6), "t"))),
      DataError);
}

}  // namespace
}  // namespace eha::web
