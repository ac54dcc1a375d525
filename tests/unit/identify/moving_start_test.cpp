// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/moving_start.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "ident/excitation/portable_draw.hpp"
#include "ident/fractional/simulate.hpp"

namespace eha::identify {
namespace {

/// Two lags, 0.5 s and 0.17 s, behind a dead time of 0.4 s, under levels. @param before  rows that are not recorded
Source levels_to_two_lags(Eigen::Index before, int seed) {
  constexpr double kTick_s = 0.02;
  constexpr Eigen::Index kTicks = 1500;
  ident::PortableDraw draw(seed);
  Eigen::VectorXd input(kTicks + before);
  double level = 0.0;
  Eigen::Index held = 0;
  for (Eigen::Index k = 0; k < input.size(); ++k) {
    if (k >= 50 && held-- <= 0) {  // at rest at 0 before
      level = std::round(4.0 * draw.uniform()) - 2.0;
      held = 15 + static_cast<Eigen::Index>(60.0 * draw.uniform());
    }
    input[k] = level;
  }
  const Eigen::VectorXd output =
      ident::simulate({{{4.0, 0.0}}, {{0.085, 2.0}, {0.67, 1.0}, {1.0, 0.0}}, 0.4}, input, kTick_s);
  Source source;
  source.name = "lags.csv";
  source.record.step_s = kTick_s;
  source.record.input_channel = {"valve", "V"};
  source.record.output_channel = {"rod", "mm"};
  source.record.input = input.tail(kTicks);
  source.record.output = output.tail(kTicks);
  for (double& y : source.record.output) y += 0.05 * draw.normal();
  return source;
}

bool leaves_out_a_start(const Identification& found) {
  return std::any_of(found.warnings.begin(), found.warnings.end(),
                     [](const std::string& sentence) { return sentence.starts_with("the record begins in motion"); });
}

TEST(MovingStart, DoesNotCostTheSimplerStructure) {
  int left_out = 0;
  for (int seed = 1; seed <= 2; ++seed) {
    const Source source = levels_to_two_lags(300, seed);
    const Identification found = identify(source, task_of(source), {}, {});
    left_out += leaves_out_a_start(found) ? 1 : 0;
    for (const IdentifiedModel& one : found.models) {
      if (one.result.model.name != found.recommendation.model) continue;
      EXPECT_EQ(one.result.model.transfer_function.numerator.size(), 1U)
          << "seed " << seed << ": " << one.result.model.name;
      EXPECT_LE(one.result.model.transfer_function.denominator.size(), 3U) << "seed " << seed;
    }
  }
  EXPECT_GE(left_out, 1);
}

TEST(MovingStart, OfADeadTimeIsNoZeroInTheRightHalfPlane) {
  constexpr double kTick_s = 0.01;
  constexpr double kDead_s = 0.05;
  ident::PortableDraw draw(3);
  Source source;
  source.name = "lag.csv";
  source.record.step_s = kTick_s;
  source.record.input = Eigen::VectorXd::Zero(3000);
  for (int tone = 1; tone <= 20; ++tone) {  // at a level from the first row on, before which the plant was at rest
    const double phase = 6.28 * draw.uniform();
    for (Eigen::Index k = 0; k < 3000; ++k) {
      source.record.input[k] += 0.3 * std::cos(0.314 * tone * kTick_s * static_cast<double>(k) + phase);
    }
  }
  Eigen::VectorXd input = Eigen::VectorXd::Zero(3100);
  input.tail(3000) = source.record.input;
  source.record.output = ident::simulate({{{12.0, 0.0}}, {{0.3, 1.0}, {1.0, 0.0}}, kDead_s}, input, kTick_s).tail(3000);
  for (double& y : source.record.output) y += 50.0 + 0.01 * draw.normal();
  const Identification found = identify(source, task_of(source), {}, {});
  const auto recommended = std::find_if(found.models.begin(), found.models.end(), [&](const IdentifiedModel& one) {
    return one.result.model.name == found.recommendation.model;
  });
  ASSERT_NE(recommended, found.models.end());
  const ident::TransferFunction& g = recommended->result.model.transfer_function;
  EXPECT_EQ(g.numerator.size(), 1U) << recommended->result.model.name;
  EXPECT_NEAR(g.delay_s, kDead_s, 0.002);
}

TEST(MovingStart, IsNoneOfARecordThatBeginsAtRest) {
  for (int seed = 1; seed <= 2; ++seed) {
    const Source source = levels_to_two_lags(0, seed);
    const Identification found = identify(source, task_of(source), {}, {});
    EXPECT_FALSE(leaves_out_a_start(found)) << "seed " << seed;
    EXPECT_FALSE(found.recommendation.model.empty()) << "seed " << seed;
  }
}

TEST(RestingStart, CountsForNothingWhereTheMotionBeginsLate) {
  Source source = levels_to_two_lags(0, 3);
  const Eigen::Index rows = source.record.input.size();
  const Eigen::Index rest = 12 * rows;
  ident::PortableDraw draw(4);
  Eigen::VectorXd input = Eigen::VectorXd::Zero(rest + rows);
  input.tail(rows) = source.record.input;
  Eigen::VectorXd output(rest + rows);
  for (Eigen::Index k = 0; k < rest; ++k) output[k] = 0.05 * draw.normal();
  output.tail(rows) = source.record.output;
  source.record.input = input;
  source.record.output = output;
  const Identification found = identify(source, task_of(source), {}, {});
  ASSERT_FALSE(found.recommendation.model.empty());
  EXPECT_TRUE(std::any_of(found.warnings.begin(), found.warnings.end(), [](const std::string& sentence) {
    return sentence.starts_with("the input rests at first, for 9") && sentence.find("--discard ") != std::string::npos;
  }));
}

}  // namespace
}  // namespace eha::identify
