// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/time_grid.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/importer/import.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::importer {
namespace {

/// Step that the reader finds in these printed times.
double step_of(const std::vector<std::string>& times) {
  std::string text = "time_s,voltage_V\n";
  for (const std::string& time : times) text += time + ",0\n";
  const test::TemporaryFolder folder;
  return import_input(folder.write("u.csv", text), {}, "V").series.step_s;
}

std::string fault_of(const std::vector<std::string>& times) {
  try {
    static_cast<void>(step_of(times));
  } catch (const DataError& error) {
    const std::string message = error.what();
    return message.substr(message.find("u.csv"));
  }
  return "no fault";
}

std::vector<std::string> printed(double start_s, double step_s, int rows, const std::string& format) {
  std::vector<std::string> times;
  for (int k = 0; k < rows; ++k) times.push_back(fmt::format(fmt::runtime(format), start_s + k * step_s));
  return times;
}

TEST(TimeGrid, FindsTheStepWhateverTheFormat) {
  for (const char* format : {"{:.3f}", "{}", "{:.17g}", "{:.6f}", "{:.9e}"}) {
    EXPECT_DOUBLE_EQ(step_of(printed(0.0, 0.001, 5000, format)), 0.001) << format;
    EXPECT_DOUBLE_EQ(step_of(printed(12.5, 0.04, 5000, format)), 0.04) << format;
  }
  EXPECT_DOUBLE_EQ(step_of(printed(0.0, 1.0, 50, "{:.0f}")), 1.0);
  EXPECT_DOUBLE_EQ(step_of(printed(0.0, 3600.0, 50, "{:.0f}")), 3600.0);
  EXPECT_DOUBLE_EQ(step_of(printed(-1.0, 1e-6, 5000, "{:.6f}")), 1e-6);
}

TEST(TimeGrid, FindsAStepThatTheDigitsCannotHold) {
  EXPECT_NEAR(step_of(printed(0.0, 1.0 / 1024.0, 5000, "{:.6f}")), 1.0 / 1024.0, 1e-9);
  EXPECT_NEAR(step_of(printed(0.0, 1.0 / 3.0, 500, "{:.3f}")), 1.0 / 3.0, 1e-5);
  EXPECT_NEAR(step_of(printed(0.0, 1.0 / 300.0, 20000, "{:.6g}")), 1.0 / 300.0, 1e-7);
}

TEST(TimeGrid, AcceptsTimesThatWereAddedUp) {
  std::vector<std::string> times;
  double time_s = 0.0;
  for (int k = 0; k < 100000; ++k, time_s += 0.001) times.push_back(fmt::format("{}", time_s));
  EXPECT_NEAR(step_of(times), 0.001, 1e-12);
}

TEST(TimeGrid, NamesTheLineOfAGap) {
  auto times = printed(0.0, 0.001, 1000, "{:.3f}");
  times.erase(times.begin() + 500);
  EXPECT_EQ(fault_of(times).substr(0, 84),
            "u.csv:502: a step of 0.002 s in time_s, expected 0.001 s (1 row missing); a record n");
  times.erase(times.begin() + 700, times.begin() + 705);
  EXPECT_EQ(fault_of(times).substr(0, 14), "u.csv:502: a s");
}

TEST(TimeGrid, OffersTheLongestPartBesideAGapBeforeFillingIt) {
  auto times = printed(0.0, 0.01, 1000, "{:.2f}");
  times.erase(times.begin() + 300, times.begin() + 360);
  const std::string fault = fault_of(times);
  const std::size_t cut = fault.find("--from 3.6`");
  ASSERT_NE(cut, std::string::npos) << fault;
  EXPECT_LT(cut, fault.find("--resample`")) << fault;
  EXPECT_NE(fault.find("(60 rows missing)"), std::string::npos) << fault;
}

/// Times about an even grid: each row is early or late by up to a third of the step.
std::vector<std::string> scattered(int rows) {
  std::vector<std::string> times;
  for (int k = 0; k < rows; ++k) {
    times.push_back(fmt::format("{:.4f}", 0.02 * (k + 0.66 * (std::fmod(k * 0.618034 + 0.3, 1.0) - 0.5))));
  }
  return times;
}

TEST(TimeGrid, OffersBothReadingsOfAClockThatScattersAboutAnEvenGrid) {
  const std::string fault = fault_of(scattered(1000));
  EXPECT_NE(fault.find("about an even grid of 0.02 s, and no row is missing; if the rows were sampled evenly"),
            std::string::npos)
      << fault;
  EXPECT_NE(fault.find("--period 0.02`; if the times are those of the samples: `"), std::string::npos) << fault;
  EXPECT_NE(fault.find("--resample`"), std::string::npos) << fault;
}

TEST(TimeGrid, OffersNoPeriodWhereARowIsMissing) {
  std::vector<std::string> times = scattered(1000);
  times.erase(times.begin() + 500);
  const std::string fault = fault_of(times);
  EXPECT_EQ(fault.find("--period"), std::string::npos) << fault;
  EXPECT_NE(fault.find("--resample`"), std::string::npos) << fault;
}

TEST(TimeGrid, OffersThePeriodForThePartBesideAGapOfAScatteringClock) {
  std::vector<std::string> times = scattered(1000);
  times.erase(times.begin() + 700, times.begin() + 780);
  const std::string fault = fault_of(times);
  EXPECT_NE(fault.find("--period 0.02 --to 13.9"), std::string::npos) << fault;
  EXPECT_LT(fault.find("--period"), fault.find("--resample")) << fault;
}

TEST(TimeGrid, NamesTheLineOfAJitteringRow) {
  auto times = printed(0.0, 0.01, 1000, "{:.6f}");
  times[300] = "3.001000";
  EXPECT_EQ(fault_of(times).substr(0, 62), "u.csv:302: a step of 0.011 s in time_s, expected 0.01 s; a rec");
  // 3 % of a step: too far from the grid, where 2 % is even.
  times[300] = "3.000300";
  EXPECT_EQ(fault_of(times).substr(0, 40), "u.csv:302: time_s is 3.0003, 0.0003 s of");
}

TEST(TimeGrid, NamesTheLineWhereTimeStopsOrGoesBack) {
  auto times = printed(0.0, 0.01, 100, "{:.2f}");
  times[50] = times[49];
  EXPECT_EQ(fault_of(times).substr(0, 56), "u.csv:52: time_s goes from 0.49 to 0.49: it must increas");
  times[50] = "0.1";
  EXPECT_EQ(fault_of(times).substr(0, 56), "u.csv:52: time_s goes from 0.49 to 0.1: it must increase");
}

TEST(TimeGrid, NamesALineOfTimesThatDriftOffTheGrid) {
  std::vector<std::string> times;
  // Each step is within the printed digits of the last, yet the period slowly grows by a tenth.
  double time_s = 0.0;
  for (int k = 0; k < 2000; ++k, time_s += 0.01 * (1.0 + 5e-5 * k)) times.push_back(fmt::format("{:.3f}", time_s));
  EXPECT_NE(fault_of(times).find("off an even grid of"), std::string::npos) << fault_of(times);
}

TEST(TimeGrid, CountsCommentLinesAndBlankLines) {
  const test::TemporaryFolder folder;
  const auto path = folder.write("u.csv", "# one\ntime_s,voltage_V\n0,0\n# two\n\n1,0\n2,0\n# three\n4,0\n");
  try {
    static_cast<void>(import_input(path, {}, "V"));
    FAIL() << "no fault";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("u.csv:9: a step of 2 s"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace eha::importer
