// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/design/low_peak_phases.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <vector>

namespace eha::ident {
namespace {

std::vector<std::size_t> first_harmonics(std::size_t count) {
  std::vector<std::size_t> harmonics(count);
  std::iota(harmonics.begin(), harmonics.end(), 1U);
  return harmonics;
}

/// Schroeder's phases of a flat spectrum, IEEE Trans. Inf. Theory 16(1), 1970.
Eigen::VectorXd schroeder(Eigen::Index count) {
  Eigen::VectorXd phase(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    phase[k] = -std::numbers::pi * static_cast<double>(k * (k + 1)) / static_cast<double>(count);
  }
  return phase;
}

TEST(LowPeakPhases, MakeOneSineASine) {
  const Eigen::VectorXcd one = Eigen::VectorXcd::Ones(1);
  EXPECT_NEAR(crest_factor_of({3}, one, low_peak_phases({3}, {one})), std::numbers::sqrt2, 1e-9);
}

TEST(LowPeakPhases, KeepThirtyFlatTonesBelowThePublishedCrestFactor) {
  const auto harmonics = first_harmonics(30);
  const Eigen::VectorXcd flat = Eigen::VectorXcd::Ones(30);
  // What Schroeder's phases give pins the measure of the crest factor itself.
  EXPECT_NEAR(crest_factor_of(harmonics, flat, schroeder(30)), 1.724, 0.02);
  EXPECT_LT(crest_factor_of(harmonics, flat, low_peak_phases(harmonics, {flat})), 1.42);
}

TEST(LowPeakPhases, KeepVoltsAndTheTravelOfAnIntegratorLowTogether) {
  const auto harmonics = first_harmonics(30);
  const Eigen::VectorXcd volts = Eigen::VectorXcd::Ones(30);
  Eigen::VectorXcd travel(30);
  for (Eigen::Index k = 0; k < 30; ++k) travel[k] = std::complex<double>(0.0, -1.0 / static_cast<double>(k + 1));
  const Eigen::VectorXd phase = low_peak_phases(harmonics, {volts, travel});
  EXPECT_LT(crest_factor_of(harmonics, volts, phase), 1.55);
  EXPECT_LT(crest_factor_of(harmonics, travel, phase), 1.55);
  EXPECT_GT(crest_factor_of(harmonics, travel, schroeder(30)), 2.0);
}

TEST(LowPeakPhases, AreTheSameForTheSameSeed) {
  const auto harmonics = first_harmonics(8);
  const Eigen::VectorXcd flat = Eigen::VectorXcd::Ones(8);
  EXPECT_EQ(low_peak_phases(harmonics, {flat}, 3, 5), low_peak_phases(harmonics, {flat}, 3, 5));
}

}  // namespace
}  // namespace eha::ident
