// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/periods.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "ident/excitation/portable_draw.hpp"

namespace eha::ident {
namespace {

/// A cosine with a third harmonic, `length` samples a period.
Eigen::VectorXd periodic(Eigen::Index length, Eigen::Index count) {
  return Eigen::VectorXd::NullaryExpr(length * count, [&](Eigen::Index k) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(k % length) / static_cast<double>(length);
    return 2.0 * std::cos(angle) + 0.5 * std::sin(3.0 * angle);
  });
}

Eigen::VectorXd normal_noise(Eigen::Index samples, double std, std::uint64_t seed) {
  PortableDraw draw(seed);
  return Eigen::VectorXd::NullaryExpr(samples, [&](Eigen::Index) { return std * draw.normal(); });
}

TEST(CommonPeriod, IsTheShortestThatHoldsWholeCyclesOfEveryLineInWholeSamples) {
  EXPECT_EQ(common_period({0.05, 0.2, 0.65}, 0.001, 50000), 20000U);
  EXPECT_EQ(common_period({0.3}, 0.001, 50000), 10000U);  // 3333.3 samples a cycle
  EXPECT_EQ(common_period({0.2, 0.3}, 0.04, 500), 250U);
}

TEST(CommonPeriod, IsNoneWhereTheRecordIsTooShortOrTheLinesShareNone) {
  EXPECT_EQ(common_period({0.05, 0.2, 0.65}, 0.001, 19999), 0U);
  EXPECT_EQ(common_period({1.0, std::numbers::sqrt2}, 0.001, 100000), 0U);
  EXPECT_EQ(common_period({}, 0.001, 100000), 0U);
}

TEST(LastPeriods, EndWithTheRecord) {
  const Periods periods = last_periods(50000, 20000, 10000);
  EXPECT_EQ(periods.first, 10000U);
  EXPECT_EQ(periods.count, 2U);
  EXPECT_EQ(last_periods(150500, 50000, 400).first, 500U);
}

TEST(LastPeriods, RefuseARecordThatHoldsFewerThanTwo) {
  EXPECT_THROW(static_cast<void>(last_periods(50000, 20000, 10001)), DataError);
  EXPECT_THROW(static_cast<void>(last_periods(50000, 0, 0)), DataError);
  EXPECT_THROW(static_cast<void>(last_periods(50, 20, 60)), DataError);
}

TEST(AveragePeriods, TakeAPeriodicSignalAndAParabolicDriftApartExactly) {
  constexpr Eigen::Index kLength = 200;
  for (const Eigen::Index count : {2, 3, 7}) {
    const Eigen::VectorXd clean = periodic(kLength, count);
    const Eigen::VectorXd drift = Eigen::VectorXd::NullaryExpr(clean.size(), [&](Eigen::Index k) {
      const double t = static_cast<double>(k) / static_cast<double>(clean.size());
      return 3.0 * t - 1.2 * t * t;
    });
    const PeriodicSignal parts =
        average_periods(clean + drift, {0, kLength, static_cast<std::size_t>(count)}, Drift::remove);
    EXPECT_TRUE(parts.drift_detected);
    EXPECT_LT((parts.drift.array() - drift.array() + drift.mean()).abs().maxCoeff(), 1e-11);
    EXPECT_LT((parts.mean.array() - drift.mean() - clean.head(kLength).array()).abs().maxCoeff(), 1e-11);
    EXPECT_LT(parts.noise_std, 1e-11);
  }
}

TEST(AveragePeriods, RecoverTheNoiseLevelWithinItsSamplingError) {
  constexpr Eigen::Index kLength = 1000;
  constexpr Eigen::Index kCount = 4;
  constexpr double kStd = 0.1;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Eigen::VectorXd signal = periodic(kLength, kCount) + normal_noise(kLength * kCount, kStd, seed);
    for (const Drift drift : {Drift::keep, Drift::remove}) {
      const PeriodicSignal parts = average_periods(signal, {0, kLength, kCount}, drift);
      // A standard deviation from n degrees of freedom has a standard error of std / sqrt(2 n); four of them.
      const double freedom = static_cast<double>(kLength * (kCount - 1) - 2);
      EXPECT_NEAR(parts.noise_std, kStd, 4.0 * kStd / std::sqrt(2.0 * freedom)) << "seed " << seed;
      // Power of the periodic part: (2^2 + 0.5^2) / 2.
      EXPECT_NEAR(parts.signal_to_noise_dB, 10.0 * std::log10(2.125 / (kStd * kStd)), 0.3) << "seed " << seed;
    }
  }
}

TEST(AveragePeriods, FindNoDriftInWhiteNoise) {
  constexpr Eigen::Index kLength = 500;
  constexpr Eigen::Index kCount = 3;
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Eigen::VectorXd signal = periodic(kLength, kCount) + normal_noise(kLength * kCount, 0.1, seed);
    found += average_periods(signal, {0, kLength, kCount}, Drift::remove).drift_detected ? 1 : 0;
  }
  // At 99.9 % 0.2 are expected; more than 3 have a chance of 1 in 20 000.
  EXPECT_LE(found, 3);
}

TEST(AveragePeriods, RefusePeriodsThatTheSignalDoesNotHold) {
  const Eigen::VectorXd signal = periodic(100, 3);
  EXPECT_THROW(static_cast<void>(average_periods(signal, {1, 100, 3}, Drift::keep)), DataError);
  EXPECT_THROW(static_cast<void>(average_periods(signal, {0, 100, 1}, Drift::keep)), DataError);
  EXPECT_THROW(static_cast<void>(average_periods(signal, {0, 0, 2}, Drift::keep)), DataError);
}

}  // namespace
}  // namespace eha::ident
