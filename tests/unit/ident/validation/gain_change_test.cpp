// SPDX-License-Identifier: GPL-3.0-or-later
// A gain that changes at once, told from drifts, from a gain that drifts, and from a model that is off all along.
#include "ident/validation/gain_change.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr Eigen::Index kChangeRows = 3000;
constexpr double kChangeStep_s = 0.05;

/// The finding on a record of 150 s, whose measured output is made of time and of the model's.
std::optional<GainChange> change_in(const std::function<double(double, double)>& measured, std::uint64_t seed = 1) {
  std::mt19937_64 draw(seed);
  Eigen::VectorXd time_s(kChangeRows);
  Eigen::VectorXd output(kChangeRows);
  Eigen::VectorXd simulated(kChangeRows);
  double level = 0.0;
  for (Eigen::Index k = 0; k < kChangeRows; ++k) {
    if (k % 60 == 0) level = 4.0 + 2.0 * normal(draw);
    time_s[k] = kChangeStep_s * static_cast<double>(k);
    simulated[k] = level;
    output[k] = measured(time_s[k], level) + 0.05 * normal(draw);
  }
  return gain_change(time_s, output, simulated);
}

TEST(GainChange, IsFoundAtItsTime) {
  for (const double at_s : {30.0, 75.0, 110.0}) {
    for (const double ratio : {0.6, 1.4}) {
      const auto found = change_in([&](double t_s, double y) { return t_s < at_s ? y : ratio * y; });
      ASSERT_TRUE(found) << at_s;
      EXPECT_NEAR(found->time_s, at_s, 1.6);
      EXPECT_NEAR(found->ratio, ratio, 0.05);
    }
  }
}

TEST(GainChange, IsFoundBesideADriftThatBeginsWithIt) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto found =
        change_in([](double t_s, double y) { return t_s < 75.0 ? y : 0.78 * y - 0.1 * (t_s - 75.0); }, seed);
    ASSERT_TRUE(found) << seed;
    EXPECT_NEAR(found->time_s, 75.0, 1.6);
    EXPECT_NEAR(found->ratio, 0.78, 0.05);
    EXPECT_FALSE(change_in([](double t_s, double y) { return t_s < 75.0 ? y : y - 0.1 * (t_s - 75.0); }, seed))
        << "a drift alone";
  }
}

TEST(OtherGain, IsNearestBesideAnOffset) {
  const Eigen::VectorXd simulated = Eigen::VectorXd::LinSpaced(500, -2.0, 7.0).array().sin();
  const Eigen::VectorXd noise = Eigen::VectorXd::LinSpaced(500, 0.0, 400.0).array().cos() * 0.01;
  const OtherGain found = other_gain(1.05 * simulated + noise + Eigen::VectorXd::Constant(500, 3.0), simulated);
  EXPECT_NEAR(found.ratio, 1.05, 2e-3);
  EXPECT_NEAR(found.rms_error, 0.01 / std::sqrt(2.0), 3e-4);
}

TEST(GainChange, IsNoDriftAndNoOtherError) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    EXPECT_FALSE(change_in([](double, double y) { return y; }, seed));
    EXPECT_FALSE(change_in([](double t_s, double y) { return y + 0.02 * t_s; }, seed));
    EXPECT_FALSE(change_in([](double t_s, double y) { return (1.0 + 0.003 * t_s) * y; }, seed));
    EXPECT_FALSE(change_in([](double, double y) { return 1.3 * y; }, seed));
    EXPECT_FALSE(change_in([](double, double y) { return y + 0.1 * y * std::abs(y); }, seed));
    EXPECT_FALSE(change_in([](double t_s, double y) { return y + std::sin(0.2 * t_s); }, seed));
    EXPECT_FALSE(change_in([](double t_s, double y) { return t_s < 70.0 ? y : y + 1.5; }, seed)) << "an offset";
  }
}

}  // namespace
}  // namespace eha::ident
