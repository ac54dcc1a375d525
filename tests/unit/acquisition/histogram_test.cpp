// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace eha::acquisition {
namespace {

TEST(Histogram, KeepsTheMaximumAndWhenItWas) {
  Histogram histogram;
  histogram.add(5'000, 1);
  histogram.add(2'000'000, 2);
  histogram.add(7'000, 3);
  EXPECT_EQ(histogram.maximum_ns(), 2'000'000);
  EXPECT_EQ(histogram.maximum_at_ns(), 2);
  EXPECT_EQ(histogram.count(), 3u);
  EXPECT_EQ(histogram.buckets()[Histogram::kBuckets - 1], 1u);
}

TEST(Histogram, GivesThePercentilesOfTheSortedValuesToAMicrosecond) {
  std::mt19937_64 random(3);
  std::exponential_distribution<double> distribution(1.0 / 30'000.0);
  Histogram histogram;
  std::vector<std::int64_t> values;
  for (int k = 0; k < 20'000; ++k) {
    values.push_back(static_cast<std::int64_t>(distribution(random)));
    histogram.add(values.back(), k);
  }
  std::sort(values.begin(), values.end());
  for (const double share : {0.5, 0.9, 0.99, 0.999}) {
    const auto rank = static_cast<std::size_t>(std::ceil(share * 20'000.0)) - 1;
    EXPECT_NEAR(histogram.percentile_us(share), static_cast<double>(values[rank]) / 1000.0, 1.0) << share;
  }
}

TEST(Histogram, IsZeroWhenEmptyAndTakesNegativeDurationsAsZero) {
  Histogram histogram;
  EXPECT_DOUBLE_EQ(histogram.percentile_us(0.5), 0.0);
  histogram.add(-100, 1);
  EXPECT_EQ(histogram.buckets()[0], 1u);
  EXPECT_EQ(histogram.maximum_ns(), 0);
}

}  // namespace
}  // namespace eha::acquisition
