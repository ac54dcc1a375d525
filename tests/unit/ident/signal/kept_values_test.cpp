// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/kept_values.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace eha::ident
