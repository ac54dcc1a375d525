// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/kept_values.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace eha::ident {
namespace {

TEST(KeptValues, AreTheRunsOfOneValueInTheirOrder) {
  const Eigen::VectorXd values{{1.0, 1.0, 2.0, 3.0, 3.0, 3.0}};
  std::vector<std::pair<Eigen::Index, Eigen::Index>> runs;
  each_kept_value(values, [&](Eigen::Index first, Eigen::Index last) { runs.emplace_back(first, last); });
  EXPECT_EQ(runs, (std::vector<std::pair<Eigen::Index, Eigen::Index>>{{0, 1}, {2, 2}, {3, 5}}));
  each_kept_value(Eigen::VectorXd(), [](Eigen::Index, Eigen::Index) { FAIL() << "of no rows"; });
}

TEST(SameValue, IsOneToTheLastDigit) {
  EXPECT_TRUE(is_same_value(0.1 + 0.2, 0.1 + 0.2));
  EXPECT_FALSE(is_same_value(0.1 + 0.2, 0.3));
  EXPECT_TRUE(is_same_value(std::numeric_limits<double>::quiet_NaN(), 0.3)) << "a missing one ends no stay";
}

TEST(StandsAtEnd, TellsAStopFromTheCrestsOfACoarseSensor) {
  Eigen::VectorXd sine(2000);
  for (Eigen::Index k = 0; k < sine.size(); ++k) sine[k] = std::sin(0.02 * static_cast<double>(k));
  const Eigen::VectorXd coarse = (sine / 0.02).array().round() * 0.02;
  const Eigen::VectorXd stopped = coarse.cwiseMin(0.8);
  EXPECT_FALSE(stands_at_end(coarse, 1.0));
  EXPECT_FALSE(stands_at_end(coarse, -1.0));
  EXPECT_TRUE(stands_at_end(stopped, 1.0));
  EXPECT_FALSE(stands_at_end(stopped, -1.0));
  EXPECT_FALSE(stands_at_end(sine, 1.0)) << "one row of each value";
}

}  // namespace
}  // namespace eha::ident
