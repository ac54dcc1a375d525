// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/measured_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr std::size_t kLength = 2000;
constexpr std::size_t kCount = 3;

/// Three equal periods, a slow drift and noise with the given correlation from sample to sample.
Eigen::VectorXd periodic_output(double noise, double correlation) {
  std::mt19937_64 draw(5);
  Eigen::VectorXd y(static_cast<Eigen::Index>(kCount * kLength));
  double e = 0.0;
  for (Eigen::Index k = 0; k < y.size(); ++k) {
    const double turn = 2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(kLength);
    e = correlation * e + std::sqrt(1.0 - correlation * correlation) * normal(draw);
    y[k] = 3.0 * std::cos(turn) + std::cos(7.0 * turn + 1.0) + 1e-4 * static_cast<double>(k) + noise * e;
  }
  return y;
}

TEST(MeasuredNoise, IsWhatDiffersBetweenThePeriods) {
  EXPECT_NEAR(measured_noise(periodic_output(0.05, 0.0), {0, kLength, kCount}, 1), 0.05, 0.003);
  EXPECT_NEAR(measured_noise(periodic_output(0.0, 0.0), {0, kLength, kCount}, 1), 0.0, 1e-10);
}

TEST(MeasuredNoise, IsNotTheTransientOfTheFirstPeriod) {
  Eigen::VectorXd y = periodic_output(0.05, 0.0);
  for (Eigen::Index k = 0; k < y.size(); ++k) y[k] += 4.0 * std::exp(-static_cast<double>(k) / 250.0);
  EXPECT_NEAR(measured_noise(y, {0, kLength, kCount}, 1), 0.05, 0.004);
  // Two periods that begin later are both kept.
  EXPECT_NEAR(measured_noise(y, {kLength, kLength, kCount - 1}, 1), 0.05, 0.004);
}

TEST(MeasuredNoise, OfDecimatedRowsIsThatBehindTheFilter) {
  // White noise loses power in proportion to the band that the filter leaves; slow noise keeps it.
  EXPECT_NEAR(measured_noise(periodic_output(0.05, 0.0), {0, kLength, kCount}, 10), 0.05 / std::sqrt(10.0), 0.002);
  EXPECT_NEAR(measured_noise(periodic_output(0.05, 0.99), {0, kLength, kCount}, 10), 0.05, 0.01);
}

}  // namespace
}  // namespace eha::ident
