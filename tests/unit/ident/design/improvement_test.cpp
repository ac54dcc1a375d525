// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/design/improvement.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "core/error.hpp"
#include "ident/design/residual_noise.hpp"
#include "ident/design/tone_powers.hpp"
#include "ident/estimation/fit.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr double kStep_s = 0.05;

/// Tones on a lag 1/(a1 s^n1 + a0), two limits.
ToneProblem lag_problem() {
  const Model lag = [] {
    Model model;
    model.transfer_function = {{{0.5, 0.0}}, {{1.0, 0.9}, {0.4, 0.0}}, 0.0};
    return model;
  }();
  const std::vector<ParameterKey> parameters{order_key(1), coefficient_key(0), numerator_key(0, 1)};
  constexpr Eigen::Index kTones = 20;
  ToneProblem problem;
  problem.response.resize(kTones, 3);
  problem.noise.setOnes(kTones);
  problem.cost.resize(2, kTones);
  for (Eigen::Index k = 0; k < kTones; ++k) {
    const double f = 0.02 * std::pow(1.3, static_cast<double>(k));
    const GainSlope at = gain_slope(lag, parameters, f);
    problem.response.row(k) = (at.gain * at.slope).transpose();
    problem.cost(0, k) = 1.0;
    problem.cost(1, k) = 9.0 * std::norm(at.gain);
  }
  return problem;
}

double variance(const ToneProblem& problem, const Eigen::VectorXd& power) {
  const Eigen::MatrixXd information = (problem.response.adjoint() * power.asDiagonal() * problem.response).real();
  return information.inverse()(problem.target, problem.target);
}

TEST(TonePowers, AreBetterThanAnyDraw) {
  const ToneProblem problem = lag_problem();
  const Eigen::VectorXd best = tone_powers(problem);
  EXPECT_NEAR((problem.cost * best).maxCoeff(), 1.0, 1e-9);
  EXPECT_GE(best.minCoeff(), 0.0);
  const double least = variance(problem, best);
  std::mt19937_64 draw(3);
  for (int trial = 0; trial < 2000; ++trial) {
    Eigen::VectorXd power(best.size());
    for (double& p : power) p = std::pow(uniform(draw), 8);
    power /= (problem.cost * power).maxCoeff();
    EXPECT_GE(variance(problem, power), 0.95 * least) << trial;
  }
}

TEST(ResidualNoise, ContinuesItsAutocorrelation) {
  const ResidualNoise noise{4.0, 4.0 * (1.0 - 0.81), {0.9}, {1.0, 0.9}, false};
  EXPECT_NEAR(noise_power(noise, 0.04, 0.0), noise.variance / 0.01, 1e-9);
  EXPECT_NEAR(noise_power(noise, 0.04, 12.5), noise.variance / 3.61, 1e-9);
  const ResidualModel coloured = coloured_residual(noise, 1000);
  EXPECT_NEAR(coloured.autocovariance.at(30), 4.0 * std::pow(0.9, 30), 1e-12);
  EXPECT_NEAR(coloured.effective_samples, 1000.0 * 0.1 / 1.9, 1e-6);
  EXPECT_NEAR(white_residual(noise, 1000).autocovariance.front(), 4.0 * (1.0 - 0.81), 1e-12);
}

Model fitted_model(const Model& truth, const Eigen::VectorXd& input, std::uint64_t seed) {
  Record record;
  record.step_s = kStep_s;
  record.input = input;
  record.output = simulate(truth, input, kStep_s);
  std::mt19937_64 draw(seed);
  for (double& y : record.output) y += 0.02 * normal(draw);
  StructureOptions asked = asked_for(structures::fo());
  return fit(record, asked, {}).model;
}

ImprovementTask task() {
  ImprovementTask task;
  task.limits = {.lowest_V = -5.0,
                 .highest_V = 5.0,
                 .slew_V_per_s = 20.0,
                 .lowest_output = -8.0,
                 .highest_output = 8.0,
                 .step_s = kStep_s};
  return task;
}

double std_of(const Model& model, const std::string& name) {
  for (const ParameterEstimate& p : model.parameters) {
    if (p.name == name) return p.std;
  }
  return NAN;
}

TEST(Improvement, AchievesWhatItPredictsWithinTheLimits) {
  const Model truth = fractional(0.6, 1.75, 0.9, 0.3, 0.46);
  const Model before = fitted_model(truth, excitation(kStep_s), 2);
  const Improvement found = improve(before, "n2", task());
  EXPECT_LT(found.std, 0.7 * std_of(before, "n2"));
  Eigen::VectorXd input = Eigen::VectorXd::Constant(1000, found.offset_V);
  for (const Tone& tone : found.tones) add_tone(tone, kStep_s, input);
  EXPECT_LE(input.cwiseAbs().maxCoeff(), 5.0);
  EXPECT_LE((input.tail(999) - input.head(999)).cwiseAbs().maxCoeff() / kStep_s, 20.0);
  const Eigen::VectorXd output = simulate(truth, input, kStep_s);
  EXPECT_LE(output.cwiseAbs().maxCoeff(), 8.0);
  const double achieved = std_of(fitted_model(truth, input, 3), "n2");
  EXPECT_LT(achieved, 1.5 * found.std);
  EXPECT_GT(achieved, found.std / 1.5);
  EXPECT_NEAR(predicted_std(before, "n2", input, task()), found.std, 1e-9 * found.std);
}

TEST(Improvement, RefusesWhatItCannotImprove) {
  const Model model = fitted_model(fractional(0.6, 1.75, 0.9, 0.3, 0.46), excitation(kStep_s), 2);
  EXPECT_THROW((void)improve(model, "n7", task()), ConfigError);
  EXPECT_THROW((void)improve(model, "initial_output", task()), ConfigError);
  ImprovementTask narrow = task();
  narrow.limits.highest_output = -7.9;
  EXPECT_THROW((void)improve(model, "n2", narrow), ConfigError);
  ImprovementTask other = task();
  other.options.decimation = 2;
  EXPECT_THROW((void)improve(model, "n2", other), ConfigError);
}

}  // namespace
}  // namespace eha::ident
