// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/excitation_order.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "ident/excitation/prms.hpp"
#include "ident/validation/verdict.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

constexpr double kStep_s = 0.04;

Eigen::VectorXd tones(const std::vector<double>& frequencies_Hz) {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(600);
  for (std::size_t f = 0; f < frequencies_Hz.size(); ++f) {
    for (Eigen::Index k = 0; k < u.size(); ++k) {
      const double t = kStep_s * static_cast<double>(k);
      u[k] += std::cos(2.0 * std::numbers::pi * frequencies_Hz[f] * t + static_cast<double>(f));
    }
  }
  return u;
}

TEST(ExcitationOrder, IsTwiceTheNumberOfTones) {
  EXPECT_EQ(excitation_order(tones({0.2})), 2U);
  EXPECT_EQ(excitation_order(tones({0.05, 0.31})), 4U);
  EXPECT_EQ(excitation_order(tones({0.05, 0.2, 0.65})), 6U);
  EXPECT_EQ(excitation_order(synthetic::excitation(0.05)), 6U) << "of the paper";
  Eigen::VectorXd offset = tones({0.2});
  offset.array() += 7.0;
  EXPECT_EQ(excitation_order(offset), 2U) << "an offset is none";
}

TEST(ExcitationOrder, IsNotRaisedByTheNoiseOfAMeasuredInput) {
  Eigen::VectorXd u = tones({0.2});
  std::mt19937_64 draw(4);
  for (double& value : u) value += 0.01 * synthetic::normal(draw);
  EXPECT_EQ(excitation_order(u), 2U);
}

TEST(ExcitationOrder, IsHighForLevelsAndSteps) {
  EXPECT_EQ(excitation_order(Prms{.amplitude_V = 2.0, .levels = 7, .hold_s = 0.4, .seed = 1}.volts(kStep_s, 1000)),
            20U);
  Eigen::VectorXd step = Eigen::VectorXd::Zero(600);
  step.tail(500).setOnes();
  EXPECT_GE(excitation_order(step).value_or(0), 5U);
}

TEST(ExcitationOrder, IsUnknownForAConstantOrAShortInput) {
  EXPECT_FALSE(excitation_order(Eigen::VectorXd::Ones(600)));
  EXPECT_FALSE(excitation_order(tones({0.2}).head(100)));
}

}  // namespace
}  // namespace eha::ident
