// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/held_levels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "ident/excitation/portable_draw.hpp"

namespace eha::ident {
namespace {

/// Levels in turn, each held for 12 to 60 rows.
Eigen::VectorXd staircase(const std::vector<double>& levels, Eigen::Index rows) {
  PortableDraw draw(3);
  Eigen::VectorXd input(rows);
  std::size_t at = 0;
  for (Eigen::Index k = 0; k < rows; ++at) {
    const auto held = std::min<Eigen::Index>(rows - k, 12 + static_cast<Eigen::Index>(48.0 * draw.uniform()));
    input.segment(k, held).setConstant(levels[at % levels.size()]);
    k += held;
  }
  return input;
}

Eigen::VectorXd with_noise(Eigen::VectorXd input, double std) {
  PortableDraw draw(5);
  for (double& value : input) value += std * draw.normal();
  return input;
}

TEST(HeldLevels, AreFoundBeneathTheNoiseOfTheirChannel) {
  for (const double noise : {0.001, 0.02, 0.05}) {
    const Eigen::VectorXd truth = staircase({-1.0, 1.0, 0.5}, 3000);
    const Eigen::VectorXd held = held_levels(with_noise(truth, noise)).value();
    // The mean of 12 rows at least.
    EXPECT_LT((held - truth).cwiseAbs().maxCoeff(), 4.5 * noise / std::sqrt(12.0)) << noise;
  }
}

TEST(HeldLevels, AreNoneOfAnInputThatMovesOrHasNoNoise) {
  const Eigen::VectorXd steps = staircase({-1.0, 1.0, 0.5}, 3000);
  EXPECT_FALSE(held_levels(steps));
  for (const double period : {20.0, 200.0, 2000.0}) {
    const Eigen::VectorXd sine = Eigen::VectorXd::LinSpaced(6000, 0.0, 6000.0 * 6.2832 / period).array().sin();
    EXPECT_FALSE(held_levels(sine)) << period;
  }
  const Eigen::VectorXd noise = with_noise(Eigen::VectorXd::Zero(3000), 1.0);
  EXPECT_FALSE(held_levels(noise));
}

TEST(TwoLevels, AreThoseOfATwoLevelInputWithNoiseAndOfNoOther) {
  const auto levels = two_levels(with_noise(staircase({-1.0, 2.0}, 3000), 0.03));
  ASSERT_TRUE(levels);
  EXPECT_NEAR((*levels)[0], -1.0, 0.03);
  EXPECT_NEAR((*levels)[1], 2.0, 0.03);
  EXPECT_FALSE(two_levels(with_noise(staircase({-1.0, 2.0, 0.0}, 3000), 0.03)));
  EXPECT_FALSE(two_levels(staircase({-1.0, 2.0, 0.0}, 3000)));
  EXPECT_TRUE(two_levels(Eigen::VectorXd::Constant(100, 2.0)));
}

}  // namespace
}  // namespace eha::ident
