// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/size_hint.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace eha::identify {
namespace {

/// Rows every millisecond of an input with two tones, the faster of which is given.
Source rows_of(Eigen::Index rows, double highest_Hz) {
  Source source;
  source.record.step_s = 0.001;
  source.record.input.resize(rows);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double t = 0.001 * static_cast<double>(k);
    const double turn = 2.0 * std::numbers::pi * t;
    source.record.input[k] = std::sin(0.3 * highest_Hz * turn) + std::sin(highest_Hz * turn);
  }
  source.record.output = source.record.input;
  return source;
}

std::string command(int every) { return fmt::format("eha fit r.csv --decimate {}", every); }

TEST(SizeHint, IsNoneWhereFewRowsAreCompared) {
  EXPECT_FALSE(size_hint(rows_of(12'000, 0.5), 1));
  EXPECT_FALSE(size_hint(rows_of(30'000, 0.5), 5));
}

TEST(SizeHint, NamesTheRowsAndACommandWhoseRowsShowTheInput) {
  const auto hint = size_hint(rows_of(30'000, 0.65), 1, command);
  ASSERT_TRUE(hint);
  EXPECT_FALSE(hint->is_grave);
  EXPECT_EQ(hint->sentence.rfind("30000 rows are compared, which may take minutes; 6000, one every 0.005 s", 0), 0U)
      << hint->sentence;
  EXPECT_TRUE(hint->sentence.ends_with("`eha fit r.csv --decimate 5`")) << hint->sentence;
  EXPECT_TRUE(size_hint(rows_of(1'200'000, 0.5), 1)->is_grave);
}

TEST(SizeHint, OffersNoDecimationThatHidesTheInput) {
  const auto hint = size_hint(rows_of(60'000, 45.0), 1, command);
  ASSERT_TRUE(hint);
  EXPECT_EQ(hint->sentence.find("--decimate"), std::string::npos) << hint->sentence;
  EXPECT_NE(hint->sentence.find("fewer would miss"), std::string::npos) << hint->sentence;
  const auto some = size_hint(rows_of(60'000, 11.0), 1, command);
  ASSERT_TRUE(some);
  EXPECT_NE(some->sentence.find("--decimate 4`"), std::string::npos) << some->sentence;
}

}  // namespace
}  // namespace eha::identify
