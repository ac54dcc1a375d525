// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/correlation.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/error.hpp"
#include "ident/validation/score.hpp"

namespace eha::ident {
namespace {

using Vector = Eigen::VectorXd;

Vector autoregressive(double pole, Eigen::Index samples, std::mt19937_64& draw) {
  std::normal_distribution<double> normal;
  Vector signal(samples);
  double state = normal(draw) / std::sqrt(1.0 - pole * pole);
  for (double& value : signal) {
    value = state;
    state = pole * state + normal(draw);
  }
  return signal;
}

TEST(Score, MatchesFiguresWorkedOutByHand) {
  // e = {0.5, -0.5, 0, 1}: sum e^2 = 1.5; y - mean = {-1.5, -0.5, 0.5, 1.5}: sum = 5.
  const Score result = score(Eigen::Vector4d(1, 2, 3, 4), Eigen::Vector4d(0.5, 2.5, 3, 3));
  EXPECT_DOUBLE_EQ(result.r2_percent, 70.0);
  EXPECT_DOUBLE_EQ(result.fit_percent, 100.0 * (1.0 - std::sqrt(0.3)));
  EXPECT_DOUBLE_EQ(result.mse, 0.375);
  EXPECT_EQ(result.error_min, -0.5);
  EXPECT_EQ(result.error_max, 1.0);
  EXPECT_EQ(result.samples, 4U);
}

TEST(Score, IsMinusInfinityForAConstantThatIsMissedAndAHundredForOneThatIsMet) {
  const Vector constant = Vector::Constant(5, 2.0);
  EXPECT_EQ(score(constant, constant).r2_percent, 100.0);
  EXPECT_EQ(score(constant, Vector::Zero(5)).r2_percent, -std::numeric_limits<double>::infinity());
}

TEST(Score, RefusesLengthsThatDiffer) {
  EXPECT_THROW((void)score(Vector::Zero(3), Vector::Zero(4)), DataError);
  EXPECT_THROW((void)score(Vector(0), Vector(0)), DataError);
}

TEST(Autocorrelation, MatchesFiguresWorkedOutByHand) {
  // Mean 2.5 removed: {-1.5, -0.5, 0.5, 1.5}; products at lag 1: 0.75 - 0.25 + 0.75 = 1.25 of 5; at lag 2: -0.75 -
  // 0.75.
  const Correlation acf = autocorrelation(Eigen::Vector4d(1, 2, 3, 4), 2);
  EXPECT_EQ(acf.lags, (std::vector<int>{0, 1, 2}));
  EXPECT_DOUBLE_EQ(acf.values[0], 1.0);
  EXPECT_DOUBLE_EQ(acf.values[1], 0.25);
  EXPECT_DOUBLE_EQ(acf.values[2], -0.3);
  EXPECT_NEAR(acf.bound95, 1.96 / 2.0, 1e-4);
  EXPECT_NEAR(acf.bound99, 2.576 / 2.0, 1e-4);
}

TEST(Autocorrelation, IsZeroForAConstantAndShortForAShortSignal) {
  const Correlation acf = autocorrelation(Vector::Constant(3, 0.1), 20);
  EXPECT_EQ(acf.lags, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(acf.values, (std::vector<double>{0.0, 0.0, 0.0}));
}

TEST(Autocorrelation, RefusesWhatIsNotFinite) {
  Vector e = Vector::Ones(4);
  e(2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)autocorrelation(e, 2), DataError);
  EXPECT_THROW((void)autocorrelation(Vector(0), 2), DataError);
}

TEST(CrossCorrelation, ShowsAtAPositiveLagAResidualThatFollowsTheInput) {
  std::mt19937_64 draw(5);
  const Vector u = autoregressive(0.0, 400, draw);
  Vector e = Vector::Zero(400);
  e.tail(397) = 2.0 * u.head(397);
  const Correlation ccf = cross_correlation(e, u, 5);
  ASSERT_EQ(ccf.lags.size(), 11U);
  EXPECT_EQ(ccf.lags.front(), -5);
  for (std::size_t i = 0; i < ccf.lags.size(); ++i) {
    if (ccf.lags[i] == 3) {
      EXPECT_GT(ccf.values[i], 0.98);
    } else {
      EXPECT_LT(std::abs(ccf.values[i]), 0.2);
    }
  }
}

TEST(CrossCorrelation, IgnoresMeansAndScales) {
  std::mt19937_64 draw(6);
  const Vector u = autoregressive(0.9, 300, draw);
  const Vector e = autoregressive(0.5, 300, draw);
  const Correlation plain = cross_correlation(e, u, 4);
  const Correlation moved = cross_correlation(Vector(3.0 * e.array() + 10.0), Vector(0.1 * u.array() - 7.0), 4);
  for (std::size_t i = 0; i < plain.values.size(); ++i) EXPECT_NEAR(plain.values[i], moved.values[i], 1e-12);
  EXPECT_NEAR(plain.bound95, moved.bound95, 1e-12);
}

TEST(CrossCorrelation, RefusesLengthsThatDiffer) {
  EXPECT_THROW((void)cross_correlation(Vector::Zero(3), Vector::Zero(4), 2), DataError);
}

/// Share of runs in which independent signals leave the bound of the given level at one positive lag.
double share_outside(double residual_pole, double input_pole, bool bound99) {
  constexpr int kRuns = 2000;
  std::mt19937_64 draw(11);
  int outside = 0;
  for (int run = 0; run < kRuns; ++run) {
    const Vector e = autoregressive(residual_pole, 500, draw);
    const Vector u = autoregressive(input_pole, 500, draw);
    const Correlation ccf = cross_correlation(e, u, 3);
    if (std::abs(ccf.values.back()) > (bound99 ? ccf.bound99 : ccf.bound95)) ++outside;
  }
  return static_cast<double>(outside) / kRuns;
}

TEST(CrossCorrelation, BoundsHoldForWhiteAndForColouredSignals) {
  // 2000 runs: a true share of 0.05 stays within 0.035..0.065 with a probability of 99.8 %.
  EXPECT_NEAR(share_outside(0.0, 0.0, false), 0.05, 0.015);
  EXPECT_NEAR(share_outside(0.0, 0.95, false), 0.05, 0.015);
  EXPECT_NEAR(share_outside(0.8, 0.8, false), 0.05, 0.02);
  // With about ten independent stretches in a record the variance itself is badly known; plain 1.96 / sqrt(N) would be
  // left more than half of the time.
  EXPECT_NEAR(share_outside(0.95, 0.95, false), 0.05, 0.05);
  EXPECT_NEAR(share_outside(0.95, 0.95, true), 0.01, 0.01);
}

TEST(CrossCorrelation, BoundOfAWhiteResidualIsTheTextbookOne) {
  std::mt19937_64 draw(12);
  const Vector e = autoregressive(0.0, 5000, draw);
  const Vector u = autoregressive(0.0, 5000, draw);
  EXPECT_NEAR(cross_correlation(e, u, 3).bound95, 1.96 / std::sqrt(5000.0), 0.1 * 1.96 / std::sqrt(5000.0));
}

TEST(LjungBox, MatchesTheChiSquaredTailInClosedForm) {
  const double q1 = 100.0 * 102.0 * 0.09 / 99.0;
  const Correlation one{{0, 1}, {1.0, 0.3}, 0.0, 0.0};
  EXPECT_NEAR(ljung_box_p(one, 100), std::erfc(std::sqrt(q1 / 2.0)), 1e-12);
  const double q2 = q1 + 100.0 * 102.0 * 0.04 / 98.0;
  const Correlation two{{0, 1, 2}, {1.0, 0.3, -0.2}, 0.0, 0.0};
  EXPECT_NEAR(ljung_box_p(two, 100), std::exp(-q2 / 2.0), 1e-12);
  EXPECT_EQ(ljung_box_p(Correlation{{0}, {1.0}, 0.0, 0.0}, 100), 1.0);
}

TEST(LjungBox, RejectsWhiteNoiseAsOftenAsItsLevelSays) {
  std::mt19937_64 draw(13);
  int rejected = 0;
  for (int run = 0; run < 2000; ++run) {
    const Vector e = autoregressive(0.0, 500, draw);
    if (ljung_box_p(autocorrelation(e, 20), 500) < 0.05) ++rejected;
  }
  EXPECT_NEAR(rejected / 2000.0, 0.05, 0.02);
}

}  // namespace
}  // namespace eha::ident
