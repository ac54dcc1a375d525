// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/residual_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>

#include "ident/estimation/fit.hpp"
#include "ident/signal/decimation.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr Eigen::Index kRows = 490;
constexpr Eigen::Index kLags = 21;
constexpr int kRuns = 500;

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

TEST(ResidualTests, AlarmAtTheirLevelBesideParametersThatAreHardlyKnown) {
  // The errors of five parameters that move the output slowly, ten times as much as the noise does.
  std::mt19937_64 draw(25);
  int input = 0;
  int whiteness = 0;
  for (int run = 0; run < kRuns; ++run) {
    TestedPart part = unrelated(0.0, draw);
    part.parameter_error.resize(kRows, 5);
    for (Eigen::Index k = 0; k < kRows; ++k) {
      for (Eigen::Index p = 0; p < 5; ++p) {
        part.parameter_error(k, p) = 10.0 * std::cos(0.02 * static_cast<double>((p + 1) * k) + static_cast<double>(p));
      }
    }
    for (Eigen::Index p = 0; p < 5; ++p) part.residual += normal(draw) * part.parameter_error.col(p);
    const auto tests = residual_tests(part);
    ASSERT_TRUE(tests);
    input += tests->input.p < 0.01 ? 1 : 0;
    whiteness += tests->whiteness.p < 0.01 ? 1 : 0;
  }
  EXPECT_NEAR(input, 0.01 * kRuns, 0.01 * kRuns);
  EXPECT_NEAR(whiteness, 0.0125 * kRuns, 0.0075 * kRuns);
}

TEST(ResidualTests, AlarmAtTheirLevelInNoiseThatADecimationFilterPassed) {
  constexpr std::size_t kEvery = 8;
  const Comparison comparison = compare_every(kEvery * 634, kEvery, 0);
  std::mt19937_64 draw(26);
  for (const double correlation : {0.0, 0.99}) {
    int whiteness = 0;
    for (int run = 0; run < kRuns; ++run) {
      TestedPart part = unrelated(0.0, draw);
      Eigen::VectorXd noise(static_cast<Eigen::Index>(kEvery) * 634);
      double e = normal(draw);
      for (double& sample : noise) {
        sample = e;
        e = correlation * e + std::sqrt(1.0 - correlation * correlation) * normal(draw);
      }
      part.residual = picked(noise, comparison).head(kRows);
      part.filter_correlation = filtered_noise_correlation(comparison);
      const auto tests = residual_tests(part);
      ASSERT_TRUE(tests);
      whiteness += tests->whiteness.p < 0.01 ? 1 : 0;
    }
    EXPECT_NEAR(whiteness, 0.0125 * kRuns, 0.0075 * kRuns) << correlation;
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

/// Levels of random height, each held for 0.1 s to 1.5 s.
Eigen::VectorXd levels(std::mt19937_64& draw) {
  Eigen::VectorXd u(600);
  for (Eigen::Index k = 0; k < u.size();) {
    const double level = 4.0 * uniform(draw) - 2.0;
    const auto end = std::min(u.size(), k + 2 + static_cast<Eigen::Index>(28.0 * uniform(draw)));
    while (k < end) u[k++] = level;
  }
  return u;
}

/// The tests of a linear model on a record of it whose input a plant bends first.
ResidualTests tested_on(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& bent, std::mt19937_64& draw) {
  const Model model = fractional(0.3, 2.0, 1.0, 0.8, 1.0);
  Record record;
  record.step_s = 0.05;
  record.input = levels(draw);
  record.output = simulate(model, bent(record.input), record.step_s);
  for (double& y : record.output) y += 0.01 * normal(draw);
  return validate(model, record, {}).tests.value();
}

TEST(ResidualTests, FindAPlantThatIsNotLinear) {
  std::mt19937_64 draw(27);
  const auto saturated = [](const Eigen::VectorXd& u) { return Eigen::VectorXd(u.cwiseMin(1.6).cwiseMax(-1.6)); };
  const auto with_play = [](const Eigen::VectorXd& u) {
    Eigen::VectorXd v(u.size());
    double now = 0.0;
    for (Eigen::Index k = 0; k < u.size(); ++k) v[k] = now = std::clamp(now, u[k] - 0.1, u[k] + 0.1);
    return v;
  };
  for (int run = 0; run < 10; ++run) {
    const ResidualTests level = tested_on(saturated, draw);
    EXPECT_LT(level.nonlinearity.value().test.p, 1e-6) << run;
    EXPECT_EQ(level.nonlinearity->kind, NonlinearKind::level) << run;
    EXPECT_FALSE(level.nonlinearity->or_kind) << run;
    EXPECT_GT(level.error.value().upper, level.error->lower) << run;
    const ResidualTests play = tested_on(with_play, draw);
    EXPECT_LT(play.nonlinearity.value().test.p, 1e-6) << run;
    EXPECT_EQ(play.nonlinearity->kind, NonlinearKind::direction) << run;
  }
}

TEST(ResidualTests, NameTimeWhereTheGainDrifts) {
  std::mt19937_64 draw(41);
  const auto warming = [](const Eigen::VectorXd& u) {
    return Eigen::VectorXd(u.array() * Eigen::ArrayXd::LinSpaced(u.size(), 0.9, 1.1));
  };
  for (int run = 0; run < 10; ++run) {
    const NonlinearityTest drift = tested_on(warming, draw).nonlinearity.value();
    EXPECT_LT(drift.test.p, 1e-6) << run;
    EXPECT_EQ(drift.kind, NonlinearKind::time) << run;
    EXPECT_FALSE(drift.or_kind) << run;
  }
}

TEST(ResidualTests, NameTwoKindsOfAPlantThatHasBoth) {
  std::mt19937_64 draw(31);
  const auto with_both = [](const Eigen::VectorXd& u) {
    Eigen::VectorXd v(u.size());
    double now = 0.0;
    for (Eigen::Index k = 0; k < u.size(); ++k) {
      now = std::clamp(now, u[k] - 0.08, u[k] + 0.08);
      v[k] = std::clamp(now, -1.55, 1.55);
    }
    return v;
  };
  int named = 0;
  for (int run = 0; run < 10; ++run) {
    const NonlinearityTest both = tested_on(with_both, draw).nonlinearity.value();
    const bool is_direction = both.kind == NonlinearKind::direction || both.or_kind == NonlinearKind::direction;
    const bool is_level = both.kind == NonlinearKind::level || both.or_kind == NonlinearKind::level;
    named += is_direction && is_level ? 1 : 0;
  }
  EXPECT_GE(named, 2);
}

TEST(ResidualTests, TellWhetherTheGainFallsOrGrows) {
  std::mt19937_64 draw(29);
  const auto saturated = [](const Eigen::VectorXd& u) { return Eigen::VectorXd(u.cwiseMin(1.6).cwiseMax(-1.6)); };
  const auto widening = [](const Eigen::VectorXd& u) {
    return Eigen::VectorXd(u.array() + 0.05 * u.array() * u.array().abs());
  };
  std::map<GainTrend, int> of_saturated;
  std::map<GainTrend, int> of_widening;
  for (int run = 0; run < 20; ++run) {
    ++of_saturated[tested_on(saturated, draw).nonlinearity.value().gain];
    ++of_widening[tested_on(widening, draw).nonlinearity.value().gain];
  }
  EXPECT_GE(of_saturated[GainTrend::falls], 15);
  EXPECT_EQ(of_saturated[GainTrend::grows], 0);
  EXPECT_GE(of_widening[GainTrend::grows], 15);
  EXPECT_EQ(of_widening[GainTrend::falls], 0);
}

TEST(ResidualTests, RarelyTakeALinearPlantForAnother) {
  constexpr int kRecords = 200;
  std::mt19937_64 draw(28);
  int nonlinear = 0;
  int feedback = 0;
  for (int run = 0; run < kRecords; ++run) {
    const ResidualTests tests = tested_on([](const Eigen::VectorXd& u) { return u; }, draw);
    nonlinear += tests.nonlinearity.value().test.p < 0.01 ? 1 : 0;
    feedback += tests.future_input.value().p < 0.01 ? 1 : 0;
    EXPECT_LT(tests.error.value().lower, 1.0) << run;
  }
  EXPECT_LE(nonlinear, 0.02 * kRecords);
  EXPECT_LE(feedback, 0.02 * kRecords);
}

TEST(ResidualTests, DoNotTakeTheNoiseOfTheInputsChannelForANonlinearPlant) {
  constexpr int kRecords = 200;
  std::mt19937_64 draw(31);
  const Model model = fractional(0.3, 2.0, 1.0, 0.8, 1.0);
  for (const double spacing : {4.0, 0.7}) {  // two levels and seven
    int nonlinear = 0;
    int moved = 0;
    for (int run = 0; run < kRecords; ++run) {
      Record record;
      record.step_s = 0.05;
      record.input = (levels(draw) / spacing).array().floor() * spacing + 0.5 * spacing;
      record.output = simulate(model, record.input, record.step_s);
      for (double& u : record.input) u += 0.02 * normal(draw);
      for (double& y : record.output) y += 0.01 * normal(draw);
      const ResidualTests tests = validate(model, record, {}).tests.value();
      nonlinear += tests.nonlinearity.value().test.p < 0.01 ? 1 : 0;
      moved += tests.input.p < 0.01 ? 1 : 0;
    }
    // The levels' means have errors left, which are not among the effects that the test allows for.
    EXPECT_LE(nonlinear, 0.08 * kRecords) << spacing;
    EXPECT_LE(moved, 0.04 * kRecords) << spacing;
  }
}

TEST(Saturation, IsSeenBehindADecimationFilterAsWell) {
  std::mt19937_64 draw(33);
  const Model model = fractional(0.3, 2.0, 1.0, 0.8, 1.0);
  for (const int decimation : {1, 4}) {
    Record record;
    record.step_s = 0.05 / decimation;
    record.input = levels(draw).replicate(1, 4 * decimation).transpose().reshaped();
    record.output = simulate(model, record.input, record.step_s);
    for (double& y : record.output) y += 0.01 * normal(draw);
    FitOptions options;
    options.decimation = decimation;
    EXPECT_EQ(validate(model, record, options).saturated_percent, 0.0) << decimation;
    const double limit = 0.6 * record.output.maxCoeff();
    record.output = record.output.cwiseMin(limit);
    EXPECT_GT(validate(model, record, options).saturated_percent.value(), 5.0) << decimation;
  }
}

TEST(ResidualTests, FindThatTheOutputComesBeforeTheInput) {
  std::mt19937_64 draw(29);
  const Model plant = fractional(0.3, 2.0, 1.0, 0.8, 1.0);
  Record record;
  record.step_s = 0.05;
  record.input = levels(draw);
  Eigen::VectorXd noise(record.input.size());
  for (double& e : noise) e = 0.05 * normal(draw);
  // A controller that answers what it measured a row before.
  for (Eigen::Index k = 1; k < noise.size(); ++k) record.input[k] -= 2.0 * noise[k - 1];
  record.output = simulate(plant, record.input, record.step_s) + noise;
  const ResidualTests tests = validate(plant, record, {}).tests.value();
  EXPECT_LT(tests.future_input.value().p, 1e-6);
  EXPECT_GT(tests.input.p, 0.01);
}

TEST(ResidualTests, CountTheSamplesBehindAMoveOfTheInput) {
  std::mt19937_64 draw(4);
  TestedPart part = unrelated(0.0, draw);
  EXPECT_EQ(residual_tests(part)->moved, std::size_t{kRows});
  // One step in the middle, as a card measures it: 1 % of noise.
  for (Eigen::Index lag = 0; lag < kLags; ++lag) {
    for (Eigen::Index k = 0; k < kRows; ++k) {
      part.past_input(k, lag) = (k - lag >= kRows / 2 ? 2.0 : 0.0) + ((k - lag) % 2 == 0 ? 0.01 : -0.01);
    }
  }
  EXPECT_EQ(residual_tests(part)->moved, std::size_t{kLags - 1});
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
