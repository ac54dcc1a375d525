// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/uncertainty/covariance.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <numbers>
#include <random>

namespace eha::ident {
namespace {

using std::numbers::pi;

double normal(std::mt19937_64& generator) {
  const auto uniform = [&] { return static_cast<double>(generator() >> 11) * 0x1p-53; };
  return std::sqrt(-2.0 * std::log(1.0 - uniform())) * std::cos(2.0 * pi * uniform());
}

Eigen::VectorXd noise(Eigen::Index n, double correlation, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  Eigen::VectorXd e(n);
  double last = normal(generator);
  for (double& value : e) {
    value = last;
    last = correlation * last + std::sqrt(1.0 - correlation * correlation) * normal(generator);
  }
  return e;
}

/// A linear regression on slow tones, as a fit is near its optimum.
Eigen::MatrixXd tones(Eigen::Index n) {
  Eigen::MatrixXd columns(n, 5);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double t = 2.0 * pi * static_cast<double>(k) / static_cast<double>(n);
    columns.row(k) << 1.0, std::cos(t), std::sin(4.0 * t), std::cos(13.0 * t), std::sin(13.0 * t);
  }
  return columns;
}

/// Share of 95 % intervals that hold the true value, pooled over parameters and 400 noise seeds.
double coverage(double correlation) {
  const Eigen::Index n = 625;
  const Eigen::MatrixXd columns = tones(n);
  const Eigen::VectorXd truth = (Eigen::VectorXd(5) << 3.0, 1.0, -0.5, 0.2, 0.7).finished();
  int inside = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const Eigen::VectorXd y = columns * truth + noise(n, correlation, seed);
    const Eigen::VectorXd x = columns.householderQr().solve(y);
    const Uncertainty known = uncertainty(columns, {"a", "b", "c", "d", "e"}, residual_model(y - columns * x));
    for (Eigen::Index i = 0; i < 5; ++i) {
      inside += std::abs(x[i] - truth[i]) < known.interval_factor * std::sqrt(known.covariance(i, i)) ? 1 : 0;
    }
  }
  return inside / 2000.0;
}

TEST(Uncertainty, CoversTheTruthUnderWhiteNoise) {
  const double share = coverage(0.0);
  EXPECT_GT(share, 0.92);
  EXPECT_LT(share, 0.98);
}

TEST(Uncertainty, CoversTheTruthUnderStronglyColouredNoise) {
  const double share = coverage(0.9);
  EXPECT_GT(share, 0.90);
  EXPECT_LT(share, 0.98);
}

TEST(Uncertainty, CoversTheTruthUnderNoiseThatWanders) {
  const double share = coverage(0.99);
  EXPECT_GT(share, 0.92);
  EXPECT_LT(share, 0.98);
}

TEST(Uncertainty, OfAResidualThatIsOneLongWaveIsFinite) {
  const Eigen::MatrixXd columns = tones(625);
  ResidualModel wave;
  wave.autocovariance.assign(625, 1.0);
  wave.effective_samples = 1.0;
  EXPECT_NEAR(uncertainty(columns, {"a", "b", "c", "d", "e"}, wave).interval_factor, 3.182, 1e-3);
}

TEST(Uncertainty, IsTheTextbookFormulaUnderWhiteNoise) {
  const Eigen::MatrixXd columns = tones(625);
  ResidualModel white;
  white.autocovariance.assign(625, 0.0);
  white.autocovariance[0] = 0.25;
  white.effective_samples = 625.0;
  const Uncertainty known = uncertainty(columns, {"a", "b", "c", "d", "e"}, white);
  const Eigen::MatrixXd expected = 0.25 * 625.0 / 620.0 * (columns.transpose() * columns).inverse();
  EXPECT_LT((known.covariance - expected).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Uncertainty, NamesParametersThatCannotBeToldApart) {
  Eigen::MatrixXd columns = tones(625);
  columns.col(3) = 2.0 * columns.col(1);
  const Uncertainty known = uncertainty(columns, {"a", "b", "c", "d", "e"}, residual_model(noise(625, 0.0, 1)));
  EXPECT_EQ(known.indistinguishable, (std::vector<std::string>{"b", "d"}));
  EXPECT_TRUE(known.covariance.allFinite());
  // The combined effect of the two is determined nevertheless.
  const Eigen::VectorXd together = (Eigen::VectorXd(5) << 0.0, 1.0, 0.0, 2.0, 0.0).finished();
  const double expected = std::pow(columns.col(1).norm(), -2);
  EXPECT_NEAR(together.dot(known.covariance * together) / expected, 1.0, 0.2);
}

TEST(ResidualModel, FindsTheOrderAndCorrelationOfAnAutoregression) {
  const ResidualModel model = residual_model(noise(20000, 0.9, 3));
  ASSERT_EQ(model.coefficients.size(), 1U);
  EXPECT_NEAR(model.coefficients[0], 0.9, 0.01);
  EXPECT_NEAR(model.effective_samples / 20000.0, 0.1 / 1.9, 0.006);
}

}  // namespace
}  // namespace eha::ident
