// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/parameter_text.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "ident/model/difference_text.hpp"

namespace eha::ident {
namespace {

TEST(WithInterval, GivesHalfThe95PercentIntervalWithTheDigitsThatItJustifies) {
  const ParameterEstimate gain{.name = "K", .value = 0.130516, .std = 0.0004, .lower95 = 0.1297, .upper95 = 0.13134};
  EXPECT_NEAR(half_width95(gain), 0.00082, 1e-15);
  EXPECT_EQ(with_interval(gain), "0.13052 +- 0.00082");
  EXPECT_EQ(with_interval(gain, "±"), "0.13052 ± 0.00082");
  EXPECT_EQ(with_interval({.name = "a0", .value = 0.01, .std = 0.02, .lower95 = -0.03, .upper95 = 0.05}),
            "0.01 +- 0.04");
}

TEST(WithInterval, SaysWhereThereIsNone) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(with_interval({.name = "a1", .value = 1.0, .std = 0.0, .fixed = true}), "1");
  EXPECT_EQ(with_interval({.name = "n2", .value = 2.0, .std = 0.1, .lower95 = 1.0, .upper95 = infinity}), "2 +- ?");
  EXPECT_EQ(with_interval({.name = "K", .value = 0.130516}), "0.130516") << "the paper's procedure";
}

TEST(RoundedTo, HasTheDigitsOfTheHalfWidth) {
  EXPECT_EQ(rounded_to(-0.32418, 0.0109), "-0.324");
  EXPECT_EQ(rounded_to(-4.4e-5, 0.00071), "-0.00004");
  EXPECT_EQ(rounded_to(-4.4e-6, 0.0071), "0.0000") << "no minus before a zero";
  EXPECT_EQ(rounded_to(1234.56, 20.0), "1235");
  EXPECT_EQ(rounded_to(0.14786, 0.0), "0.1479");
}

TEST(ParameterText, WritesADifferenceWithTheDigitsThatTellItFromItsLimit) {
  const DifferenceText near = difference_text(-0.01021, 0.00998);
  EXPECT_EQ(near.difference, "-0.0102");
  EXPECT_EQ(near.half_width, "0.0100");
  EXPECT_EQ(difference_text(0.32418, 0.0109).difference, "0.324");
  EXPECT_EQ(difference_text(0.32418, 0.0109).half_width, "0.011");
  EXPECT_EQ(difference_text(0.5, 0.0).half_width, "0");
}

TEST(ParameterText, GivesADifferenceTwoDigitsAndItsValuesAsMany) {
  const DifferenceText text = difference_text(0.00677985 - 0.00674478, 0.00158);
  EXPECT_EQ(text.difference, "0.000035");
  EXPECT_EQ(rounded_to(0.00674478, text.resolution), "0.006745");
  EXPECT_EQ(rounded_to(0.00677985, text.resolution), "0.006780");
  EXPECT_EQ(difference_text(0.0, 0.00158).difference, "0.0000");
}

TEST(ParameterText, WritesAFactorWithoutAnExponent) {
  EXPECT_EQ(figure_text(1.44), "1.4");
  EXPECT_EQ(figure_text(87.3), "87");
  EXPECT_EQ(figure_text(99.7), "100");
  EXPECT_EQ(figure_text(123.7), "120");
  EXPECT_EQ(figure_text(-151.0), "-150");
  EXPECT_EQ(figure_text(2345.0), "2300");
  EXPECT_EQ(figure_text(23456.0), "23000");
  EXPECT_EQ(figure_text(3e6), "3e+06");
}

TEST(ParameterText, RoundsNoShareUpToAHundredPercent) {
  EXPECT_EQ(percent_text(99.984), "99.98");
  EXPECT_EQ(percent_text(99.9951), "above 99.99");
  EXPECT_EQ(percent_text(100.0), "100.00");
  EXPECT_EQ(percent_text(99.97, 1), "above 99.9");
}

}  // namespace
}  // namespace eha::ident
