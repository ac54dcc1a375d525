// SPDX-License-Identifier: GPL-3.0-or-later
// Models that are wrong in a known way: each is graded down, and the reason names what is wrong. Half a minute.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "ident/estimation/fit.hpp"
#include "ident/excitation/prms.hpp"
#include "ident/validation/verdict.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr double kStep_s = 0.05;
constexpr Eigen::Index kRows = 2000;
constexpr std::uint64_t kRecords = 10;

Eigen::VectorXd many_levels(std::uint64_t seed) {
  return Prms{.amplitude_V = 2.0, .levels = 7, .hold_s = 0.4, .seed = seed}.volts(kStep_s,
                                                                                  static_cast<std::size_t>(kRows));
}

Model two_poles() {
  Model model;
  model.transfer_function = {{{0.5, 0.0}}, {{0.3, 2.0}, {1.0, 1.0}, {0.5, 0.0}}, 0.0};
  return model;
}

Record record_with(const Model& model, const Eigen::VectorXd& input, std::uint64_t seed) {
  Record record;
  record.step_s = kStep_s;
  record.input = input;
  record.output = simulate(model, input, kStep_s);
  std::mt19937_64 draw(seed);
  const double level = 0.01 * std::sqrt((record.output.array() - record.output.mean()).square().mean());
  for (double& y : record.output) y += level * normal(draw);
  return record;
}

Verdict verdict_on(const Record& record, const Structure& structure) {
  const Model model = fit(record, asked_for(structure), {}).model;
  return judge(model, {});
}

bool failed(const Verdict& verdict, const std::string& criterion) {
  return std::any_of(verdict.criteria.begin(), verdict.criteria.end(),
                     [&](const Criterion& c) { return name_of(c) == criterion && !c.passed; });
}

std::string reasons_of(const Verdict& verdict) {
  std::string all;
  for (const std::string& reason : verdict.reasons) all += reason + "\n";
  return all;
}

/// A record and the structure fitted to it, and what the verdict must name.
struct Wrong {
  std::string name;
  std::function<Record(std::uint64_t)> record;
  Structure structure;
  std::string criterion;
  std::string words;
  Grade best;       ///< that it may get
  int least_named;  ///< of kRecords; a fit can hide a slow drift in its parameters
};

std::vector<Wrong> wrong_models() {
  const auto with_delay = [](std::uint64_t seed) {
    Model model = two_poles();
    model.transfer_function.delay_s = 0.3;
    return record_with(model, many_levels(seed), seed);
  };
  const auto two_resonances = [](std::uint64_t seed) {
    // (s^2 + 0.4 s + 4) (s^2 + 0.8 s + 30)
    Model model;
    model.transfer_function = {{{100.0, 0.0}}, {{1.0, 4.0}, {1.2, 3.0}, {34.32, 2.0}, {15.2, 1.0}, {120.0, 0.0}}, 0.0};
    return record_with(model, many_levels(seed), seed);
  };
  const auto saturated = [](std::uint64_t seed) {
    Record record = record_with(two_poles(), many_levels(seed), seed);
    const double limit = 0.6 * record.output.maxCoeff();
    record.output = record.output.cwiseMin(limit);
    return record;
  };
  const auto drifting_by = [](double change) {
    return [change](std::uint64_t seed) {
      Record record = record_with(two_poles(), many_levels(seed), seed);
      record.output += Eigen::VectorXd::LinSpaced(kRows, 0.0, change);
      return record;
    };
  };
  const auto exchanged = [](std::uint64_t seed) {
    Record record = record_with(two_poles(), many_levels(seed), seed);
    std::swap(record.input, record.output);
    return record;
  };
  const auto one_tone = [](std::uint64_t seed) {
    Eigen::VectorXd u(kRows);
    for (Eigen::Index k = 0; k < kRows; ++k) u[k] = 2.0 * std::cos(1.2 * kStep_s * static_cast<double>(k) + 0.4);
    return record_with(fractional(0.3, 1.7, 0.9, 0.5, 0.5), u, seed);
  };
  const auto behind = [](const std::function<double(double held, double u)>& next) {
    return [next](std::uint64_t seed) {
      Record record = record_with(two_poles(), many_levels(seed), seed);
      Eigen::VectorXd v = record.input;
      double held = 0.0;
      for (double& u : v) u = held = next(held, u);
      record.output = record_with(two_poles(), v, seed).output;
      return record;
    };
  };
  const auto limited = behind([](double, double u) { return std::clamp(u, -1.4, 1.4); });
  const auto with_play = behind([](double held, double u) { return std::clamp(held, u - 0.2, u + 0.2); });
  const auto bent_sensor = [](std::uint64_t seed) {
    Record record = record_with(two_poles(), many_levels(seed), seed);
    record.output = (record.output.array() + 0.1 * record.output.array().cube()).matrix();
    return record;
  };
  const auto two_levels = [](std::uint64_t seed) {
    const Eigen::VectorXd u = many_levels(seed).unaryExpr([](double level) { return level < 0.0 ? -1.5 : 1.5; });
    return record_with(two_poles(), u, seed);
  };
  const auto closed_loop = [](std::uint64_t seed) {
    // A controller takes the noise of the sensor for motion and answers a row later.
    Record record = record_with(two_poles(), many_levels(seed), seed);
    std::mt19937_64 draw(seed + 100);
    Eigen::VectorXd noise(kRows);
    for (double& e : noise) e = 0.02 * normal(draw);
    record.input.tail(kRows - 1) -= 8.0 * noise.head(kRows - 1);
    record.output = simulate(two_poles(), record.input, kStep_s) + noise;
    return record;
  };
  const std::string input = "still moves what the model leaves over";
  return {
      {"HiddenDelay", with_delay, structures::io(), "residual_input_p", input, Grade::usable, 10},
      {"TwoResonances", two_resonances, structures::io(), "residual_input_p", input, Grade::usable, 10},
      {"SaturatedSegment", saturated, structures::io(), "saturated_percent", "at an end", Grade::usable, 9},
      {"DriftingSensor", drifting_by(0.4), structures::io(), "validation_r2_percent", "mostly an offset",
       Grade::rejected, 10},
      {"SlowlyDriftingSensor", drifting_by(0.15), structures::io(), "residual_drift", "wanders", Grade::usable, 8},
      {"ExchangedColumns", exchanged, structures::io(), "validation_r2_percent", "may be exchanged", Grade::rejected,
       9},
      {"FarDriftingSensor", drifting_by(1.0), structures::io(), "validation_r2_percent", "The output wanders",
       Grade::rejected, 7},
      {"LimitedInput", limited, structures::io(), "nonlinearity_p", "the gain falls as the input grows", Grade::usable,
       10},
      {"Play", with_play, structures::io(), "nonlinearity_p", "play, hysteresis or a limited rate", Grade::usable, 10},
      {"BentSensor", bent_sensor, structures::io(), "nonlinearity_p", "the gain of plant or sensor", Grade::usable, 10},
      {"TwoLevels", two_levels, structures::io(), "input_levels",
       "for inputs of +-1.5 V as recorded; no statement about other amplitudes", Grade::usable, 10},
      {"ClosedLoop", closed_loop, structures::io(), "future_input_p", "a controller closes the loop", Grade::usable,
       10},
      {"TooLittleExcitation", one_tone, structures::fo(), "excitation_order", "tests the model too little",
       Grade::usable, 10}};
}

class WrongModel : public testing::TestWithParam<Wrong> {};

TEST_P(WrongModel, IsGradedDownForTheRightReason) {
  const Wrong& wrong = GetParam();
  int named = 0;
  std::string all;
  for (std::uint64_t seed = 1; seed <= kRecords; ++seed) {
    const Verdict verdict = verdict_on(wrong.record(seed), wrong.structure);
    EXPECT_LE(verdict.grade, wrong.best) << seed;
    const std::string reasons = reasons_of(verdict);
    named += failed(verdict, wrong.criterion) && reasons.find(wrong.words) != std::string::npos ? 1 : 0;
    all += reasons + "\n";
  }
  EXPECT_GE(named, wrong.least_named) << all;
}

INSTANTIATE_TEST_SUITE_P(Of, WrongModel, testing::ValuesIn(wrong_models()),
                         [](const auto& tested) { return tested.param.name; });

TEST(RightModel, IsGood) {
  for (std::uint64_t seed = 1; seed <= kRecords; ++seed) {
    const Verdict verdict = verdict_on(record_with(two_poles(), many_levels(seed), seed), structures::io());
    EXPECT_EQ(verdict.grade, Grade::good) << seed << "\n" << reasons_of(verdict);
  }
}

}  // namespace
}  // namespace eha::ident
