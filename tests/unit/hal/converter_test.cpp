// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/converter.hpp"

#include <gtest/gtest.h>

#include "hal/sim/normal_noise.hpp"

namespace eha::hal {
namespace {

TEST(Converter, EveryCodeComesBackFromItsVoltage) {
  const Converter converter(-10.0, 10.0, 16);
  for (std::uint32_t code = 0; code <= converter.last_code(); ++code) {
    ASSERT_EQ(converter.code(converter.volts(code)), code);
  }
  EXPECT_EQ(converter.last_code(), 65535U);
  EXPECT_DOUBLE_EQ(converter.volts(0), -10.0);
  EXPECT_DOUBLE_EQ(converter.volts(65535), 10.0);
}

TEST(Converter, RoundsToTheNearestCodeAndSaturatesOutside) {
  const Converter converter(0.0, 7.0, 3);
  EXPECT_EQ(converter.code(2.49), 2U);
  EXPECT_EQ(converter.code(2.51), 3U);
  EXPECT_EQ(converter.code(-1e300), 0U);
  EXPECT_EQ(converter.code(1e300), 7U);
  EXPECT_TRUE(converter.at_rail(0));
  EXPECT_TRUE(converter.at_rail(7));
  EXPECT_FALSE(converter.at_rail(1));
}

TEST(NormalNoise, HasTheMomentsOfTheNormalDistribution) {
  NormalNoise noise(7);
  const int count = 200000;
  double sum = 0.0;
  double squares = 0.0;
  double fourth = 0.0;
  for (int i = 0; i < count; ++i) {
    const double x = noise();
    sum += x;
    squares += x * x;
    fourth += x * x * x * x;
  }
  // Five standard errors of each estimate; the sum of twelve has kurtosis 2.9.
  EXPECT_NEAR(sum / count, 0.0, 5.0 / std::sqrt(count));
  EXPECT_NEAR(squares / count, 1.0, 5.0 * std::sqrt(1.9 / count));
  EXPECT_NEAR(fourth / count, 2.9, 5.0 * std::sqrt(90.0 / count));
}

}  // namespace
}  // namespace eha::hal
