// SPDX-License-Identifier: GPL-3.0-or-later
//
// Coverage of the intervals, and alarms of the residual's tests at 1 % (0.2 % for nonlinear effects), for right models
// of many records. Minutes; EHA_CAMPAIGN_RECORDS sets the records of a case.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "ident/estimation/fit.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr double kCompared_s = 0.04;
constexpr double kNoise = 0.01;   // of the output's standard deviation
constexpr double kChance = 1e-3;  // that a count is beyond its limits
constexpr double kPeak_V = 3.0;

int records_of_a_case() {
  const char* text = std::getenv("EHA_CAMPAIGN_RECORDS");
  return text != nullptr ? std::atoi(text) : 200;
}

enum class Shape { tones, levels, one_sided_levels };

struct Case {
  std::string name;
  Structure structure;
  Model truth;
  std::vector<std::string> parameters;  ///< whose intervals are counted
  double correlation = 0.0;             ///< of the noise, from row to row
  Shape shape = Shape::levels;
  int decimation = 1;
};

Model model_of(std::vector<Term> numerator, std::vector<Term> denominator) {
  Model model;
  model.transfer_function = {std::move(numerator), std::move(denominator), 0.0};
  return model;
}

Model behind(Model model, const ValveMap& map) {
  model.input_map = map;
  return model;
}

std::vector<Case> cases() {
  const Model io = model_of({{0.46, 0.0}}, {{0.3, 2.0}, {1.0, 1.0}, {0.4, 0.0}});
  const Model fo = fractional(0.3, 1.75, 0.9, 0.4, 0.46);
  const Model integrator = model_of({{0.46, 0.0}}, {{0.3, 2.0}, {1.0, 1.0}, {0.0, 0.0}});
  const Model cylinder = model_of({{0.46, 0.0}}, {{0.02, 3.0}, {0.1, 2.0}, {1.0, 1.0}, {0.0, 0.0}});
  const Model zero = model_of({{0.2, 1.0}, {0.46, 0.0}}, {{0.3, 2.0}, {1.0, 1.0}, {0.4, 0.0}});
  const ValveMap valve{-0.2, 0.3, 0.85};
  const ValveMap one_sided{0.0, 0.6, 1.0};
  const std::vector<std::string> of_io{"a2", "a0", "K"};
  const std::vector<std::string> of_fo{"a2", "n2", "n1", "a0", "K"};
  return {
      {"io", structures::io(), io, of_io},
      {"io, AR(1) 0.9", structures::io(), io, of_io, 0.9},
      {"io, AR(1) 0.99", structures::io(), io, of_io, 0.99},
      {"io, filtered", structures::io(), io, of_io, 0.0, Shape::levels, 8},
      {"io, filtered AR(1) 0.99", structures::io(), io, of_io, 0.99, Shape::levels, 8},
      {"io, tones", structures::io(), io, of_io, 0.0, Shape::tones},
      {"fo, tones", structures::fo(), fo, of_fo, 0.0, Shape::tones},
      {"fo, AR(1) 0.9", structures::fo(), fo, of_fo, 0.9},
      {"io_valve",
       structures::behind_valve(structures::io()),
       behind(io, valve),
       {"a2", "a0", "K", "null", "dead_band", "negative_gain_ratio"}},
      {"integrator_lag_valve",
       structures::behind_valve(structures::integrator_lag()),
       behind(integrator, valve),
       {"a2", "K", "null", "dead_band", "negative_gain_ratio"}},
      {"cylinder", structures::cylinder(), cylinder, {"a3", "a2", "K"}},
      {"cylinder, AR(1) 0.9", structures::cylinder(), cylinder, {"a3", "a2", "K"}, 0.9},
      {"zero", structures::io({.poles = 2, .zeros = 1}), zero, {"b1", "b0", "a2", "a0"}},
      {"one-sided",
       structures::behind_valve(structures::io()),
       behind(io, one_sided),
       {"a2", "a0", "K", "dead_band"},
       0.0,
       Shape::one_sided_levels},
  };
}

Eigen::VectorXd input_of(Shape shape, double step_s, std::mt19937_64& draw) {
  Eigen::VectorXd u = excitation(step_s);
  if (shape == Shape::tones) return u;
  const double lowest = shape == Shape::levels ? -kPeak_V : 0.0;
  for (Eigen::Index k = 0; k < u.size();) {
    // The first level is the lowest input, at which a one-sided plant rests.
    const double level = k == 0 && lowest >= 0.0 ? 0.0 : lowest + (kPeak_V - lowest) * uniform(draw);
    const double held_s = 0.1 + 1.9 * uniform(draw);
    const auto end = std::min(u.size(), k + 1 + static_cast<Eigen::Index>(held_s / step_s));
    while (k < end) u[k++] = level;
  }
  return u;
}

Record record_of(const Case& tested, std::uint64_t seed) {
  std::mt19937_64 draw(seed);
  Record record;
  record.step_s = kCompared_s / tested.decimation;
  record.input = input_of(tested.shape, record.step_s, draw);
  record.output = simulate(tested.truth, record.input, record.step_s);
  const double level = kNoise * std::sqrt((record.output.array() - record.output.mean()).square().mean());
  double e = normal(draw);
  for (double& y : record.output) {
    y += level * e;
    e = tested.correlation * e + std::sqrt(1.0 - tested.correlation * tested.correlation) * normal(draw);
  }
  return record;
}

double value_of(const Model& truth, const std::string& name) {
  if (name == "null") return truth.input_map->null;
  if (name == "dead_band") return truth.input_map->dead_band;
  if (name == "negative_gain_ratio") return truth.input_map->negative_gain_ratio;
  const TransferFunction& g = truth.transfer_function;
  const auto& terms = name == "K" || name[0] == 'b' ? g.numerator : g.denominator;
  if (name == "K") return terms[0].coefficient;
  const Term& term = terms[terms.size() - 1 - static_cast<std::size_t>(name[1] - '0')];
  return name[0] == 'n' ? term.order : term.coefficient;
}

struct Counts {
  std::map<std::string, int> inside = {};
  int input = 0;
  int whiteness = 0;
  int nonlinear = 0;
  int records = 0;
};

void count(const Case& tested, const Model& model, Counts& counts) {
  ++counts.records;
  for (const ParameterEstimate& p : model.parameters) {
    if (std::find(tested.parameters.begin(), tested.parameters.end(), p.name) == tested.parameters.end()) continue;
    const double truth = value_of(tested.truth, p.name);
    counts.inside[p.name] += p.lower95 <= truth && truth <= p.upper95 ? 1 : 0;
  }
  const ResidualTests& tests = model.validation->tests.value();
  counts.input += tests.input.p < 0.01 ? 1 : 0;
  counts.whiteness += tests.whiteness.p < 0.01 ? 1 : 0;
  counts.nonlinear += tests.nonlinearity && tests.nonlinearity->test.p < 0.002 ? 1 : 0;
}

Counts counts_of(const Case& tested, int records) {
  StructureOptions asked = asked_for(tested.structure);
  asked.initial_state = InitialState::none;
  FitOptions options;
  options.search = Search::local;
  options.decimation = tested.decimation;
  Counts counts;
  std::mutex counting;
  std::atomic<int> next{1};
  std::vector<std::jthread> threads;
  for (unsigned t = 0; t < std::max(1U, std::thread::hardware_concurrency()); ++t) {
    threads.emplace_back([&] {
      for (int seed = next++; seed <= records; seed = next++) {
        const Model model = fit(record_of(tested, static_cast<std::uint64_t>(seed)), asked, options).model;
        const std::lock_guard hold(counting);
        count(tested, model, counts);
      }
    });
  }
  threads.clear();
  return counts;
}

/// The most of `records` that a probability makes, but by kChance; the least with 1 - p.
int most_by_chance(int records, double p) {
  return static_cast<int>(quantile(complement(boost::math::binomial(records, p), kChance)));
}
int least_by_chance(int records, double p) { return records - most_by_chance(records, 1.0 - p); }

class Levels : public testing::TestWithParam<Case> {};

TEST_P(Levels, AreKeptByIntervalsAndByTestsOfTheResidual) {
  const Case& tested = GetParam();
  const int records = records_of_a_case();
  const Counts counts = counts_of(tested, records);
  ASSERT_EQ(counts.records, records);
  const auto percent = [&](int number) { return 100.0 * number / records; };
  std::printf("%-24s %d records: alarms of whiteness %.2f, input %.2f, nonlinearity %.2f %%; coverage",
              tested.name.c_str(), records, percent(counts.whiteness), percent(counts.input),
              percent(counts.nonlinear));
  for (const auto& [name, number] : counts.inside) std::printf(" %s %.1f", name.c_str(), percent(number));
  std::printf(" %%\n");
  EXPECT_LE(counts.whiteness, most_by_chance(records, 0.02));
  EXPECT_GE(counts.whiteness, least_by_chance(records, 0.005));
  EXPECT_LE(counts.input, most_by_chance(records, 0.02));
  // Noise that is nearly a random walk within the record alarms in up to 3 %, other noise in up to 1.5 %.
  EXPECT_LE(counts.nonlinear, most_by_chance(records, 0.03));
  EXPECT_EQ(counts.inside.size(), tested.parameters.size());
  for (const auto& [name, number] : counts.inside) {
    EXPECT_GE(number, least_by_chance(records, 0.92)) << name;
    EXPECT_LE(number, most_by_chance(records, 0.98)) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Of, Levels, testing::ValuesIn(cases()));

}  // namespace
}  // namespace eha::ident
