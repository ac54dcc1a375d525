// SPDX-License-Identifier: GPL-3.0-or-later
// Coverage of the reported uncertainty over many records of known systems. Takes minutes.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "ident/estimation/fit.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "ident/output_error/output_error.hpp"
#include "ident/signal/decimation.hpp"

namespace eha::ident {
namespace {

constexpr double kStep_s = 0.001;
constexpr int kDecimation = 40;
constexpr int kRecords = 400;
constexpr double kNoiseShare = 0.01;  // of the output's standard deviation, before the filter

struct System {
  std::string name;
  double a2, n2, n1, a0, gain, bias, initial_output;
};

const std::vector<System>& systems() {
  static const std::vector<System> all = {{"base", 0.6, 1.75, 0.9, 0.04, 0.46, 0.2, 3.9},
                                          {"stiff", 0.02, 1.6, 0.8, 0.5, 1.0, 0.0, 0.0},
                                          {"oscillating", 1.6, 2.2, 0.9, 2.0, 2.0, 0.1, 1.0},
                                          {"non_commensurate", 0.3, 1.63, 0.71, 0.4, 0.5, -0.1, 1.0},
                                          {"slow", 2.495, 1.31, 0.97, 0.01, 0.166, 0.0, 0.0},
                                          {"near_integrating", 0.15, 1.9, 0.98, 0.02, 0.25, 0.2, 2.9},
                                          {"integer_orders", 0.5, 2.0, 1.0, 0.4, 1.0, 0.0, 0.0},
                                          {"damped", 0.6, 1.75, 0.9, 0.23, 0.46, 0.3, -1.0}};
  return all;
}

Model model_of(const System& s) {
  Model model;
  model.transfer_function = {{{s.gain, 0.0}}, {{s.a2, s.n2}, {1.0, s.n1}, {s.a0, 0.0}}, 0.0};
  model.input_bias = s.bias;
  model.initial_output = s.initial_output;
  return model;
}

std::map<std::string, double> truth_of(const System& s) {
  return {{"K", s.gain},
          {"a2", s.a2},
          {"a0", s.a0},
          {"n2", s.n2},
          {"n1", s.n1},
          {"input_bias", s.bias},
          {"initial_output", s.initial_output}};
}

StructureOptions structure_at(const System& s) {
  StructureOptions structure;
  structure.structure = structures::fo();
  structure.name = "fo";
  structure.parameters = {
      {"n2", {}, s.n2, {}, {}}, {"n1", {}, s.n1, {}, {}}, {"a2", {}, s.a2, {}, {}}, {"a0", {}, s.a0, {}, {}}};
  return structure;
}

/// 50 s of three tones at 1 ms, without noise.
Record exact_record(const System& s) {
  Record record;
  record.step_s = kStep_s;
  record.input.resize(50'000);
  for (Eigen::Index k = 0; k < record.input.size(); ++k) {
    const double x = 2.0 * std::numbers::pi * kStep_s * static_cast<double>(k);
    record.input[k] = 1.9 * std::cos(0.05 * x + 0.3) + 1.6 * std::cos(0.2 * x + 1.9) + 1.5 * std::cos(0.65 * x + 4.2);
  }
  record.output = simulate(model_of(s), record.input, kStep_s);
  return record;
}

double noise_level(const Eigen::VectorXd& output) {
  return kNoiseShare * std::sqrt((output.array() - output.mean()).square().mean());
}

/// Moments of the estimates and how often the intervals held the truth.
struct Tally {
  int inside = 0;
  int within_three = 0;
  double sum = 0.0;
  double sum_of_squares = 0.0;

  void add(const ParameterEstimate& p, double truth) {
    inside += p.lower95 <= truth && truth <= p.upper95 ? 1 : 0;
    within_three += std::abs(p.value - truth) < 3.0 * p.std ? 1 : 0;
    sum += p.value - truth;
    sum_of_squares += (p.value - truth) * (p.value - truth);
  }
  [[nodiscard]] double variance() const { return sum_of_squares / kRecords - std::pow(sum / kRecords, 2); }
};

/// Fits kRecords noisy copies. @param correlation  of the noise between compared samples; 0: white
std::map<std::string, Tally> estimates(const System& s, double correlation) {
  Record record = exact_record(s);
  const Eigen::VectorXd exact = record.output;
  const double level = noise_level(exact);
  const double per_step = correlation > 0.0 ? std::pow(correlation, 1.0 / kDecimation) : 0.0;
  FitOptions options;
  options.search = Search::local;
  options.decimation = kDecimation;
  options.split = 1.0;
  const std::map<std::string, double> truth = truth_of(s);
  std::map<std::string, Tally> tallies;
  for (int seed = 1; seed <= kRecords; ++seed) {
    PortableDraw draw(static_cast<std::uint64_t>(seed));
    double e = draw.normal();
    for (Eigen::Index k = 0; k < exact.size(); ++k) {
      record.output[k] = exact[k] + level * e;
      e = per_step * e + std::sqrt(1.0 - per_step * per_step) * draw.normal();
    }
    for (const ParameterEstimate& p : fit(record, structure_at(s), options).model.parameters) {
      if (!p.fixed) tallies[p.name].add(p, truth.at(p.name));
    }
  }
  return tallies;
}

double pooled_coverage(const System& s, const std::map<std::string, Tally>& tallies) {
  double inside = 0.0;
  std::printf("%-17s", s.name.c_str());
  for (const auto& [name, tally] : tallies) {
    inside += tally.inside;
    std::printf(" %s %.1f %%", name.c_str(), 100.0 * tally.inside / kRecords);
  }
  const double share = inside / static_cast<double>(kRecords * tallies.size());
  std::printf("  pooled %.1f %%\n", 100.0 * share);
  return share;
}

class Statistics : public testing::TestWithParam<System> {};

TEST_P(Statistics, IntervalsHoldTheTruthUnderWhiteNoiseAndReachTheCramerRaoBound) {
  const System& s = GetParam();
  const std::map<std::string, Tally> tallies = estimates(s, 0.0);
  const double share = pooled_coverage(s, tallies);
  EXPECT_GE(share, 0.92);
  EXPECT_LE(share, 0.98);

  // The bound for the compared samples: white noise of the record, seen through the filter.
  const Record record = exact_record(s);
  const Comparison comparison =
      compare_every(static_cast<std::size_t>(record.input.size()), static_cast<std::size_t>(kDecimation), 0);
  const ComparedRecord compared(record, comparison, comparison.count, {});
  TransferFunction g = model_of(s).transfer_function;
  std::reverse(g.denominator.begin(), g.denominator.end());
  const Parametrisation plain = Parametrisation::plain(structure_at(s), g);
  LinearPart linear;
  linear.numerator.resize(1);
  linear.solve_bias = true;
  LinearSolution solution;
  solution.numerator = Eigen::VectorXd::Constant(1, s.gain);
  solution.input_bias = s.bias;
  solution.initial_output = s.initial_output;
  std::vector<ParameterKey> names;
  const Eigen::MatrixXd derivatives = OutputError(compared, plain, linear).derivatives(plain.start(), solution, names);
  const std::vector<double>& taps = comparison.taps;
  const auto rows = static_cast<Eigen::Index>(comparison.count);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(rows, rows);
  for (std::size_t lag = 0; lag * kDecimation < taps.size(); ++lag) {
    double sum = 0.0;
    for (std::size_t i = 0; i + lag * kDecimation < taps.size(); ++i) sum += taps[i] * taps[i + lag * kDecimation];
    covariance.diagonal(static_cast<Eigen::Index>(lag)).setConstant(sum);
    covariance.diagonal(-static_cast<Eigen::Index>(lag)).setConstant(sum);
  }
  const double level = noise_level(record.output);
  const Eigen::MatrixXd bound =
      level * level * (derivatives.transpose() * covariance.llt().solve(derivatives)).inverse();
  ASSERT_EQ(names.size(), tallies.size());
  double mean_ratio = 0.0;
  std::printf("%-17s variance over the bound:", s.name.c_str());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const double ratio = tallies.at(names[i].name).variance() / bound(at, at);
    std::printf(" %s %.2f", names[i].name.c_str(), ratio);
    mean_ratio += ratio / static_cast<double>(names.size());
  }
  std::printf("  mean %.2f\n", mean_ratio);
  EXPECT_GT(mean_ratio, 0.8);
  EXPECT_LT(mean_ratio, 1.2);
}

TEST_P(Statistics, IntervalsHoldTheTruthUnderStronglyColouredNoise) {
  const double share = pooled_coverage(GetParam(), estimates(GetParam(), 0.9));
  EXPECT_GE(share, 0.90);
  EXPECT_LE(share, 0.98);
}

INSTANTIATE_TEST_SUITE_P(Systems, Statistics, testing::ValuesIn(systems()),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace eha::ident
