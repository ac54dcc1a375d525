// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/residual_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ident/estimation/fit.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr Eigen::Index kRows = 490;
constexpr Eigen::Index kLags = 21;
constexpr int kRuns = 1000;

/// Noise with the given correlation from sample to sample, and an unrelated input of the same kind.
TestedPart unrelated(double correlation, std::mt19937_64& draw) {
  const double fresh = std::sqrt(1.0 - correlation * correlation);
  const auto series = [&](Eigen::Index rows) {
    Eigen::VectorXd e(rows);
    double now = normal(draw);
    for (double& sample : e) {
      sample = now;
      now = correlation * now + fresh * normal(draw);
    }
    return e;
  };
  TestedPart part;
  part.residual = series(kRows);
  const Eigen::VectorXd input = series(kRows + kLags);
  part.past_input.resize(kRows, kLags);
  for (Eigen::Index lag = 0; lag < kLags; ++lag) part.past_input.col(lag) = input.segment(kLags - lag, kRows);
  part.parameter_error.resize(kRows, 0);
  return part;
}

TEST(ResidualTests, AlarmAtTheirLevelInWhiteAndColouredNoise) {
  for (const double correlation : {0.0, 0.5, 0.9}) {
    std::mt19937_64 draw(21);
    int input = 0;
    int whiteness = 0;
    for (int run = 0; run < kRuns; ++run) {
      const auto tests = residual_tests(unrelated(correlation, draw));
      ASSERT_TRUE(tests);
      input += tests->input.p < 0.01 ? 1 : 0;
      whiteness += tests->whiteness.p < 0.01 ? 1 : 0;
    }
    RecordProperty("input_" + std::to_string(correlation), input);
    RecordProperty("whiteness_" + std::to_string(correlation), whiteness);
    EXPECT_LE(input, 0.03 * kRuns) << correlation;
    EXPECT_LE(whiteness, 0.03 * kRuns) << correlation;
  }
}

TEST(ResidualTests, FindWhatThePastInputDoes) {
  std::mt19937_64 draw(22);
  for (int run = 0; run < 20; ++run) {
    TestedPart part = unrelated(0.5, draw);
    part.residual += 0.5 * part.past_input.col(3);
    EXPECT_LT(residual_tests(part)->input.p, 0.01) << run;
  }
}

TEST(ResidualTests, LetThroughWhatTheParametersErrorsExplain) {
  // A residual that lies along the derivative by a badly known parameter is no fault of the structure.
  std::mt19937_64 draw(23);
  TestedPart part = unrelated(0.0, draw);
  part.residual += 0.5 * part.past_input.col(3);
  EXPECT_LT(residual_tests(part)->input.p, 1e-6);
  part.parameter_error = 0.5 * part.past_input.col(3);
  EXPECT_GT(residual_tests(part)->input.p, 0.01);
}

TEST(ResidualTests, AreTakenOfAModelThatKnowsNoErrors) {
  const Model by_hand = fractional(0.6, 1.75, 0.9, 0.3, 0.46);
  const ValidationReport report = validate(by_hand, record_of(by_hand, 0.05, 0.01, 3), {});
  ASSERT_TRUE(report.tests);
  EXPECT_GE(report.tests->input.p, 0.01);
}

TEST(ResidualTests, NeedThreeSamplesForEachLag) {
  std::mt19937_64 draw(24);
  TestedPart part = unrelated(0.0, draw);
  part.residual.conservativeResize(69);
  part.past_input.conservativeResize(69, Eigen::NoChange);
  part.parameter_error.resize(69, 0);
  EXPECT_FALSE(residual_tests(part));
}

}  // namespace
}  // namespace eha::ident
