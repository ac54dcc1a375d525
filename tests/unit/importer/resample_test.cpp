// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/resample.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "core/error.hpp"

namespace eha::importer {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// Rows of time, a held 10 t and an interpolated 2 t.
Rows rows_at(const std::vector<double>& times) {
  Rows rows;
  rows.columns.resize(3);
  for (const double t : times) {
    rows.columns[0].push_back(t);
    rows.columns[1].push_back(10.0 * t);
    rows.columns[2].push_back(2.0 * t);
  }
  return rows;
}

TEST(Resample, LeavesAnEvenRecordAsItIs) {
  const Resampled even = resample(rows_at({1.0, 1.5, 2.0, 2.5}), 1, {}, "r.csv");
  EXPECT_DOUBLE_EQ(even.step_s, 0.5);
  EXPECT_DOUBLE_EQ(even.start_s, 1.0);
  EXPECT_EQ(even.columns[1], (std::vector<double>{2.0, 3.0, 4.0, 5.0}));
  EXPECT_TRUE(even.filled.empty());
  EXPECT_TRUE(even.repairs.empty());
}

TEST(Resample, HoldsTheInputInALongGap) {
  const Resampled even = resample(rows_at({0.0, 1.0, 2.0, 8.0, 9.0, 10.0}), 1, {}, "r.csv");
  EXPECT_EQ(even.columns[0], (std::vector<double>{0.0, 10.0, 20.0, 20.0, 20.0, 20.0, 20.0, 20.0, 80.0, 90.0, 100.0}));
  EXPECT_DOUBLE_EQ(even.columns[1][5], 10.0);
}

TEST(Resample, InterpolatesInputAndOutputInAShortGap) {
  const Resampled even = resample(rows_at({0.0, 1.0, 2.0, 5.0, 6.0, 7.0}), 1, {}, "r.csv");
  EXPECT_EQ(even.columns[0], (std::vector<double>{0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0}));
  EXPECT_EQ(even.columns[1], (std::vector<double>{0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0}));
  EXPECT_EQ(even.filled, (std::vector<std::size_t>{3, 4}));
  ASSERT_EQ(even.repairs.size(), 1U);
  EXPECT_NE(even.repairs[0].find("3 to 4 s: nothing measured, 2 rows filled"), std::string::npos) << even.repairs[0];
}

TEST(Resample, KeepsTheInputOfALateRowAndInterpolatesItsOutput) {
  const Resampled even = resample(rows_at({0.0, 1.0, 2.2, 3.0, 4.0}), 1, {}, "r.csv");
  EXPECT_DOUBLE_EQ(even.step_s, 1.0);
  EXPECT_DOUBLE_EQ(even.columns[0][2], 22.0);
  EXPECT_NEAR(even.columns[1][2], 4.0, 1e-12);
  EXPECT_TRUE(even.filled.empty());
  ASSERT_EQ(even.repairs.size(), 1U);
  EXPECT_NE(even.repairs[0].find("off the grid, moved"), std::string::npos) << even.repairs[0];
}

TEST(Resample, CountsTheRowsThatItMoved) {
  const Resampled even = resample(rows_at({0.0, 1.1, 1.9, 3.0, 4.0}), 1, {}, "r.csv");
  EXPECT_EQ(even.moved_rows, 2U);
  EXPECT_NEAR(even.most_moved_s, 0.1, 1e-12);
}

/// Times of rows whose clock wanders: each step is 1 plus or minus up to 0.35.
std::vector<double> wandering(std::size_t rows) {
  std::vector<double> times{0.0};
  for (std::size_t k = 1; k < rows; ++k) {
    const double along = std::fmod(static_cast<double>(k) * 0.618034, 1.0);  // evenly over 0..1
    times.push_back(times.back() + 1.0 + 0.7 * (along - 0.5));
  }
  return times;
}

TEST(Resample, TakesThePointsBetweenTheRowsOfAWanderingClockAsMeasured) {
  const Resampled even = resample(rows_at(wandering(400)), 1, 1.0, "r.csv");
  EXPECT_TRUE(even.filled.empty());
  for (std::size_t k = 0; k < even.columns[1].size(); ++k) {
    // A row that is within 2 % of a step on the grid keeps its value.
    EXPECT_NEAR(even.columns[1][k], 2.0 * static_cast<double>(k), 2.0 * 0.02) << k;
  }
}

TEST(Resample, AveragesWhatAWanderingClockHeld) {
  Rows rows = rows_at(wandering(400));
  for (std::size_t k = 0; k < rows.columns[1].size(); ++k) rows.columns[1][k] = k < 200 ? 0.0 : 1.0;
  const Resampled even = resample(rows, 1, 1.0, "r.csv");
  EXPECT_TRUE(even.is_averaged);
  const double stepped_s = rows.columns[0][200];
  const auto at = static_cast<std::size_t>(stepped_s);
  EXPECT_EQ(even.columns[0][at - 1], 0.0);
  EXPECT_NEAR(even.columns[0][at], static_cast<double>(at + 1) - stepped_s, 1e-9);
  EXPECT_EQ(even.columns[0][at + 1], 1.0);
  EXPECT_FALSE(resample(rows_at({0.0, 1.0, 2.2, 3.0, 4.0}), 1, {}, "r.csv").is_averaged) << "one late row";
}

TEST(Resample, FindsTheStepOfAClockThatScatters) {
  std::vector<double> times;
  for (int k = 0; k < 1000; ++k) {
    const double along = std::fmod(k * 0.618034, 1.0);
    const double other = std::fmod(k * 0.414214, 1.0);
    times.push_back(k + 0.4 * (along - 0.5) + 0.4 * (other - 0.5));
  }
  EXPECT_DOUBLE_EQ(resample(rows_at(times), 1, {}, "r.csv").step_s, 1.0);
}

TEST(Resample, FindsTheMissingRowOfAWanderingClock) {
  std::vector<double> times = wandering(400);
  times.erase(times.begin() + 200);
  const Resampled even = resample(rows_at(times), 1, 1.0, "r.csv");
  EXPECT_LE(even.filled.size(), 1U) << "if the grid falls between its neighbours";
  times.erase(times.begin() + 200);
  EXPECT_GE(resample(rows_at(times), 1, 1.0, "r.csv").filled.size(), 1U);
}

TEST(Resample, TreatsAMissingValueAsAMissingRow) {
  Rows rows = rows_at({0.0, 1.0, 2.0, 3.0});
  rows.columns[2][2] = kMissing;
  const Resampled even = resample(rows, 1, {}, "r.csv");
  EXPECT_EQ(even.filled, (std::vector<std::size_t>{2}));
  EXPECT_DOUBLE_EQ(even.columns[1][2], 4.0);
}

TEST(Resample, KeepsTheInputOfARowWhoseOutputIsMissing) {
  Rows rows = rows_at({0.0, 1.0, 2.0, 3.0, 4.0, 5.0});
  rows.columns[2][2] = rows.columns[2][3] = kMissing;
  const Resampled even = resample(rows, 1, {}, "r.csv");
  EXPECT_EQ(even.columns[0], (std::vector<double>{0.0, 10.0, 20.0, 30.0, 40.0, 50.0}));
  EXPECT_EQ(even.columns[1], (std::vector<double>{0.0, 2.0, 4.0, 6.0, 8.0, 10.0}));
  EXPECT_EQ(even.filled, (std::vector<std::size_t>{2, 3}));
  EXPECT_TRUE(even.held.empty());
  ASSERT_EQ(even.repairs.size(), 1U);
  EXPECT_NE(even.repairs[0].find("2 to 3 s: no output measured, interpolated in 2 rows whose input is kept"),
            std::string::npos)
      << even.repairs[0];
}

TEST(Resample, NamesTheLineThatLacksAValue) {
  Rows rows = rows_at({0.0, 1.0, 2.0, 3.0, 4.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0});
  rows.has_lines = true;
  rows.header_line = 1;
  rows.line_marks = {{0, 2}};
  rows.columns[2][1] = kMissing;                       // line 3
  rows.columns[1][7] = kMissing;                       // line 9
  rows.columns[1][9] = rows.columns[2][9] = kMissing;  // line 11
  const Resampled even = resample(rows, 1, {}, "r.csv");
  std::string all;
  for (const std::string& repair : even.repairs) all += repair + "\n";
  for (const char* found : {"r.csv:3: at 1 s: no output measured", "r.csv:9: at 10 s: no input measured",
                            "r.csv:11: at 12 s: nothing measured", "r.csv:7: 5 to 7 s: nothing measured"}) {
    EXPECT_NE(all.find(found), std::string::npos) << found << "\n" << all;
  }
}

TEST(Resample, KeepsTheOutputOfARowWhoseInputIsMissing) {
  Rows rows = rows_at({0.0, 1.0, 2.0, 3.0, 4.0});
  rows.columns[1][2] = kMissing;
  rows.columns[2][2] = 7.0;
  const Resampled even = resample(rows, 1, {}, "r.csv");
  EXPECT_EQ(even.columns[0], (std::vector<double>{0.0, 10.0, 20.0, 30.0, 40.0}));
  EXPECT_DOUBLE_EQ(even.columns[1][2], 7.0);
  EXPECT_EQ(even.filled, (std::vector<std::size_t>{2}));
  EXPECT_EQ(even.held, (std::vector<std::size_t>{2}));
  ASSERT_EQ(even.repairs.size(), 1U);
  EXPECT_NE(even.repairs[0].find("at 2 s: no input measured, filled in 1 row whose output is kept"), std::string::npos)
      << even.repairs[0];
}

TEST(Resample, TakesWhatARowLacksFromAnotherOfItsTime) {
  Rows rows = rows_at({0.0, 1.0, 2.0, 2.0, 3.0});
  rows.columns[2][2] = kMissing;
  rows.columns[1][3] = kMissing;
  const Resampled even = resample(rows, 1, {}, "r.csv");
  EXPECT_EQ(even.columns[0], (std::vector<double>{0.0, 10.0, 20.0, 30.0}));
  EXPECT_EQ(even.columns[1], (std::vector<double>{0.0, 2.0, 4.0, 6.0}));
  EXPECT_TRUE(even.filled.empty());
  EXPECT_TRUE(even.repairs.empty());
}

TEST(Resample, BeginsAndEndsWhereInputAndOutputAreKnown) {
  Rows rows = rows_at({0.0, 1.0, 2.0, 3.0, 4.0, 5.0});
  rows.columns[2][0] = kMissing;
  rows.columns[1][5] = kMissing;
  const Resampled even = resample(rows, 1, {}, "r.csv");
  EXPECT_DOUBLE_EQ(even.start_s, 1.0);
  EXPECT_EQ(even.columns[1], (std::vector<double>{2.0, 4.0, 6.0, 8.0}));
}

TEST(Resample, FindsARoundStepUnderJitter) {
  std::vector<double> times;
  for (int k = 0; k < 1000; ++k) times.push_back(0.01 * k + 0.001 * std::sin(7.0 * k));
  EXPECT_DOUBLE_EQ(resample(rows_at(times), 1, {}, "r.csv").step_s, 0.01);
}

TEST(Resample, RefusesTimeThatGoesBackAndAGapLongerThanTheRecord) {
  EXPECT_THROW(static_cast<void>(resample(rows_at({0.0, 1.0, 0.5}), 1, {}, "r.csv")), DataError);
  EXPECT_THROW(static_cast<void>(resample(rows_at({0.0, 1.0, 1e9}), 1, {}, "r.csv")), DataError);
  EXPECT_THROW(static_cast<void>(resample(rows_at({0.0, 1.0, 2.0}), 1, 0.1, "r.csv")), DataError);
  EXPECT_THROW(static_cast<void>(resample(rows_at({0.0}), 1, {}, "r.csv")), DataError);
}

}  // namespace
}  // namespace eha::importer
