// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/intersample.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace eha::ident {
namespace {

/// A sine of 0.5 Hz, sampled every 40 ms, and what an integrator makes of the signal itself.
Record sampled_sine() {
  constexpr double kRate = std::numbers::pi;
  Record record;
  record.step_s = 0.04;
  record.start_s = 2.0;
  record.input.resize(200);
  record.output.resize(200);
  for (Eigen::Index k = 0; k < 200; ++k) {
    const double t = 0.04 * static_cast<double>(k);
    record.input[k] = std::cos(kRate * t);
    record.output[k] = std::sin(kRate * t) / kRate;
  }
  return record;
}

TEST(Intersample, KeepsTheMeasuredRowsAndTheirTimes) {
  const Record record = sampled_sine();
  for (const Intersample intersample : {Intersample::held, Intersample::straight}) {
    const Record fine = in_parts(record, intersample);
    ASSERT_EQ(fine.output.size(), 199 * kPartsOfARow + 1);
    EXPECT_DOUBLE_EQ(fine.step_s, 0.04 / kPartsOfARow);
    EXPECT_EQ(fine.start_s, 2.0);
    for (Eigen::Index k = 0; k < 200; ++k) EXPECT_EQ(fine.output[k * kPartsOfARow], record.output[k]);
  }
}

TEST(Intersample, HoldsOrFollowsTheInput) {
  const Record record = sampled_sine();
  const Record held = in_parts(record, Intersample::held);
  const Record straight = in_parts(record, Intersample::straight);
  double held_in = 0.0;
  double straight_in = 0.0;
  double worst_held = 0.0;
  double worst_straight = 0.0;
  for (Eigen::Index k = 0; k + 1 < held.input.size(); ++k) {
    EXPECT_EQ(held.input[k], record.input[k / kPartsOfARow]);
    held_in += held.step_s * held.input[k];
    straight_in += straight.step_s * straight.input[k];
    if ((k + 1) % kPartsOfARow != 0) continue;
    worst_held = std::max(worst_held, std::abs(held_in - record.output[(k + 1) / kPartsOfARow]));
    worst_straight = std::max(worst_straight, std::abs(straight_in - record.output[(k + 1) / kPartsOfARow]));
  }
  EXPECT_GT(worst_held, 0.01);
  EXPECT_LT(worst_straight, 5e-4);
}

TEST(Intersample, InterpolatesTheOutputByCubics) {
  const Record fine = in_parts(sampled_sine(), Intersample::straight);
  for (Eigen::Index k = 0; k < fine.output.size(); ++k) {
    const double t = fine.step_s * static_cast<double>(k);
    EXPECT_NEAR(fine.output[k], std::sin(std::numbers::pi * t) / std::numbers::pi, 2e-5) << k;
  }
}

TEST(Intersample, TellsASampledSignalFromLevels) {
  EXPECT_NEAR(movement_within_half_a_row(sampled_sine().input), 0.02 * std::numbers::pi, 2e-3);
  Eigen::VectorXd levels(200);
  for (Eigen::Index k = 0; k < 200; ++k) levels[k] = k / 20 % 2 == 0 ? 1.0 : -1.0;
  EXPECT_EQ(movement_within_half_a_row(levels), 0.0);
  EXPECT_EQ(movement_within_half_a_row(Eigen::VectorXd::Constant(200, 1.0)), 0.0);
}

TEST(Intersample, TellsASumOfTonesFromLevelsHoweverFewRowsTheirPeriodHas) {
  Eigen::VectorXd tones = Eigen::VectorXd::Zero(1800);
  const double rate_Hz = 30.0;
  for (const double f : {0.5, 1.0, 2.0, 3.5, 5.0, 8.0, 10.0}) {
    for (Eigen::Index k = 0; k < tones.size(); ++k) {
      tones[k] += std::cos(2.0 * std::numbers::pi * f * static_cast<double>(k) / rate_Hz + f * f);
    }
  }
  EXPECT_GT(movement_within_half_a_row(tones), 0.3);
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  Eigen::VectorXd levels(1800);
  for (double& level : levels) level = normal(random);
  EXPECT_EQ(movement_within_half_a_row(levels), 0.0) << "another level each row";
}

}  // namespace
}  // namespace eha::ident
