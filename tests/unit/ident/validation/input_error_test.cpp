// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/input_error.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "ident/estimation/fit.hpp"
#include "ident/signal/intersample.hpp"
#include "ident/structure/structures.hpp"
#include "ident/validation/verdict.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr double kRodStep_s = 0.01;
constexpr double kRounding_V = 0.001;

Eigen::VectorXd in_steps(const Eigen::VectorXd& signal, double step) { return (signal / step).array().round() * step; }

/// Tones of 0.05 Hz to 3.05 Hz, 60 s. @param apart  of their distances; 0: periods of 20 s
Eigen::VectorXd multisine(std::mt19937_64& draw, double apart_Hz = 0.013) {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(6000);
  for (int tone = 1; tone < 60; ++tone) {
    const double phase = 2.0 * std::numbers::pi * uniform(draw);
    for (Eigen::Index k = 0; k < u.size(); ++k) {
      u[k] += 0.15 * std::cos(2.0 * std::numbers::pi * (0.05 * tone + apart_Hz * std::sqrt(tone)) * kRodStep_s *
                                  static_cast<double>(k) +
                              phase);
    }
  }
  return u;
}

Model rod_model() {
  Model model;
  model.transfer_function = {{{1.2, 0.0}}, {{0.04, 2.0}, {1.0, 1.0}}, 0.0};
  return model;
}

/// The test for nonlinear effects of a rod's own model, on a record whose input is rounded.
NonlinearityTest nonlinearity_on(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& bent,
                                 std::mt19937_64& draw, double apart_Hz = 0.013) {
  Record record;
  record.step_s = kRodStep_s;
  const Eigen::VectorXd applied = multisine(draw, apart_Hz);
  record.output = simulate(rod_model(), bent(applied), kRodStep_s);
  for (double& y : record.output) y += 1e-4 * normal(draw);
  record.input = in_steps(applied, kRounding_V);
  return validate(rod_model(), record, {}).tests.value().nonlinearity.value();
}

TEST(InputRounding, StepIsTheLeastDifferenceOfTwoValues) {
  std::mt19937_64 draw(1);
  EXPECT_NEAR(rounding_step(in_steps(multisine(draw), kRounding_V)), kRounding_V, 1e-9);
  EXPECT_LT(rounding_step(multisine(draw)), 1e-5);
}

TEST(InputRounding, OfACommandInLevelsIsNone) {
  Eigen::VectorXd levels(400);
  for (Eigen::Index k = 0; k < levels.size(); ++k) {
    const Eigen::Index level = k / 5;
    levels[k] = 0.1 * static_cast<double>(level);
  }
  EXPECT_EQ(rounding_step(levels), 0.0);
  for (Eigen::Index k = 0; k < levels.size(); ++k) levels[k] = k % 2 == 0 ? 1.0 : -1.0;
  EXPECT_EQ(rounding_step(levels), 0.0);
}

TEST(InputRounding, BeforeAnIntegratorIsNoNonlinearity) {
  constexpr int kRecords = 8;
  const auto linear = [](const Eigen::VectorXd& u) { return u; };
  for (const double apart_Hz : {0.013, 0.0}) {
    std::mt19937_64 draw(2);
    int alarms = 0;
    for (int run = 0; run < kRecords; ++run) alarms += nonlinearity_on(linear, draw, apart_Hz).test.p < 0.01 ? 1 : 0;
    EXPECT_EQ(alarms, 0) << apart_Hz;
  }
}

TEST(InputRounding, HidesNoPlay) {
  std::mt19937_64 draw(3);
  const auto with_play = [](const Eigen::VectorXd& u) {
    Eigen::VectorXd v(u.size());
    double now = 0.0;
    for (Eigen::Index k = 0; k < u.size(); ++k) v[k] = now = std::clamp(now, u[k] - 0.01, u[k] + 0.01);
    return v;
  };
  for (int run = 0; run < 10; ++run) {
    const NonlinearityTest play = nonlinearity_on(with_play, draw);
    EXPECT_LT(play.test.p, 1e-6) << run;
    EXPECT_EQ(play.kind, NonlinearKind::direction) << run;
  }
}

TEST(InputNoise, IsSeenOnAHeldAndOnASmoothInputAlone) {
  std::mt19937_64 draw(4);
  Eigen::VectorXd held(4000);
  for (Eigen::Index k = 0; k < held.size(); ++k) held[k] = (k / 25) % 3 == 0 ? 1.0 : -0.5;
  const Eigen::VectorXd smooth = multisine(draw);
  EXPECT_EQ(white_noise(held), 0.0);
  EXPECT_LT(white_noise(smooth), 1e-6);
  for (const Eigen::VectorXd& input : {held, smooth}) {
    Eigen::VectorXd noisy = input;
    for (double& u : noisy) u += 0.002 * normal(draw);
    EXPECT_NEAR(white_noise(noisy), 0.002, 2e-4);
  }
  Eigen::VectorXd excitation(4000);
  for (double& u : excitation) u = normal(draw);
  EXPECT_EQ(white_noise(excitation), 0.0);
}

/// How many of 8 intervals of the gain of a rod hold it, whose input was measured with noise of 4 mV.
int gains_within_their_intervals(const std::function<Eigen::VectorXd(std::mt19937_64&)>& drawn_input) {
  constexpr int kRecords = 8;
  const StructureOptions asked = asked_for(structures::integrator_lag());
  int within = 0;
  for (int run = 0; run < kRecords; ++run) {
    std::mt19937_64 draw(100 + static_cast<std::uint64_t>(run));
    Record record;
    record.step_s = kRodStep_s;
    record.input = drawn_input(draw);
    record.output = simulate(rod_model(), record.input, kRodStep_s);
    for (double& u : record.input) u += 0.004 * normal(draw);
    for (double& y : record.output) y += 5e-4 * normal(draw);
    const Model model = fit(record, asked, {}).model;
    const auto gain = std::find_if(model.parameters.begin(), model.parameters.end(),
                                   [](const ParameterEstimate& p) { return p.name == "K"; });
    within += gain->lower95 <= 1.2 && 1.2 <= gain->upper95 ? 1 : 0;
  }
  return within;
}

TEST(InputNoise, BeforeAnIntegratorEntersTheIntervalOfItsGain) {
  EXPECT_GE(gains_within_their_intervals([](std::mt19937_64& draw) -> Eigen::VectorXd { return multisine(draw); }), 7);
  EXPECT_GE(gains_within_their_intervals([](std::mt19937_64& draw) {
              Eigen::VectorXd u(3000);
              for (Eigen::Index k = 0; k < u.size(); ++k) {
                u[k] = k % 40 == 0 ? 2.0 * uniform(draw) - 1.0 : u[k - 1];
              }
              return u;
            }),
            7);
}

/// Levels of -1 to 1 V, each held for 40 rows.
Eigen::VectorXd held_levels_of(std::mt19937_64& draw) {
  Eigen::VectorXd u(3000);
  for (Eigen::Index k = 0; k < u.size(); ++k) u[k] = k % 40 == 0 ? 2.0 * uniform(draw) - 1.0 : u[k - 1];
  return u;
}

Model lag_model() {
  Model model;
  model.transfer_function = {{{1.8, 0.0}}, {{0.024, 2.0}, {0.38, 1.0}, {1.0, 0.0}}, 0.0};
  return model;
}

TEST(NoisyInput, IsNamedInPlaceOfANonlinearPlantWhereThePlantDidNotGetTheNoise) {
  int named = 0;
  int taken_for_noise = 0;
  for (int run = 0; run < 6; ++run) {
    for (const double noise_V : {0.05, 0.2, 0.3}) {
      std::mt19937_64 draw(300 + static_cast<std::uint64_t>(run));
      const Eigen::VectorXd levels = held_levels_of(draw);
      Record record;
      record.step_s = 0.02;
      record.input = levels;
      for (double& u : record.input) u += noise_V * normal(draw);
      record.output = simulate(lag_model(), levels, record.step_s);
      for (double& y : record.output) y += 0.002 * normal(draw);
      Model model = lag_model();
      model.validation = validate(model, record, {});
      const std::vector<std::string> reasons = judge(model, {}).reasons;
      if (model.validation->input_noise) {
        ++named;
        EXPECT_NEAR(model.validation->input_noise->rms, noise_V, 0.1 * noise_V);
        EXPECT_EQ(reasons.front().rfind("The measured input is noisy: ", 0), 0U) << reasons.front();
        for (const std::string& reason : reasons) EXPECT_EQ(reason.find("not linear"), std::string::npos) << reason;
      }
      // The same noise, which the plant did get.
      record.output = simulate(lag_model(), record.input, record.step_s);
      for (double& y : record.output) y += 0.002 * normal(draw);
      taken_for_noise += validate(lag_model(), record, {}).input_noise ? 1 : 0;
    }
  }
  EXPECT_EQ(named, 18);
  EXPECT_EQ(taken_for_noise, 0);
}

TEST(CoarseInput, IsNamedInPlaceOfFeedbackOrFriction) {
  constexpr double kStep_V = 0.02;
  for (const int seed : {1, 2, 3, 4}) {
    std::mt19937_64 draw(static_cast<std::uint64_t>(seed));
    Eigen::VectorXd u = Eigen::VectorXd::Zero(16000);
    for (int tone = 0; tone < 25; ++tone) {
      const double frequency_Hz = std::round(8.0 * std::pow(120.0, tone / 24.0)) / 8.0;
      const double phase = 2.0 * std::numbers::pi * uniform(draw);
      for (Eigen::Index k = 0; k < u.size(); ++k) {
        u[k] += 0.15 * std::cos(2.0 * std::numbers::pi * frequency_Hz * 0.0005 * static_cast<double>(k) + phase);
      }
    }
    Model model;  // 38 Hz, D = 0.12
    const double w = 2.0 * std::numbers::pi * 38.0;
    model.transfer_function = {{{2.0, 0.0}}, {{1.0 / (w * w), 2.0}, {0.24 / w, 1.0}, {1.0, 0.0}}, 0.0};
    Record record;
    record.step_s = 0.0005;
    record.input = (u / kStep_V).array().round() * kStep_V;
    record.output = simulate(model, u, record.step_s);
    for (double& y : record.output) y += 0.002 * normal(draw);
    model.validation = validate(model, record, {});
    ASSERT_TRUE(model.validation->input_noise) << seed;
    EXPECT_NEAR(model.validation->input_noise->step, kStep_V, 1e-9);
    const std::vector<std::string> reasons = judge(model, {}).reasons;
    EXPECT_EQ(reasons.front().rfind("The recorded input is coarse: ", 0), 0U) << reasons.front();
    for (const std::string& reason : reasons) EXPECT_EQ(reason.find("controller"), std::string::npos) << reason;
    // The same steps, which the plant did get.
    record.output = simulate(model, record.input, record.step_s);
    for (double& y : record.output) y += 0.002 * normal(draw);
    EXPECT_FALSE(validate(model, record, {}).input_noise) << seed;
  }
}

TEST(BetweenRows, AreStraightLinesTooCoarseForASmoothInputOfFewRowsAPeriod) {
  for (const int every : {1, 5}) {
    // 0.6 and 1.7 Hz, every 10 and 50 ms
    Record fine;
    fine.step_s = 0.001;
    fine.input.resize(60000);
    for (Eigen::Index k = 0; k < fine.input.size(); ++k) {
      const double t = fine.step_s * static_cast<double>(k);
      fine.input[k] = std::sin(2.0 * std::numbers::pi * 0.6 * t) + std::sin(2.0 * std::numbers::pi * 1.7 * t + 1.0);
    }
    Model model = lag_model();
    fine.output = simulate(model, fine.input, fine.step_s);
    Record rows;
    rows.step_s = 0.01 * every;
    const Eigen::Index apart = 10 * every;
    rows.input = fine.input(Eigen::seq(0, Eigen::last, apart));
    rows.output = fine.output(Eigen::seq(0, Eigen::last, apart));
    std::mt19937_64 draw(5);
    for (double& y : rows.output) y += 0.01 * normal(draw);
    FitOptions options;
    options.decimation = kPartsOfARow;
    model.validation = validate(model, in_parts(rows, Intersample::straight), options);
    ASSERT_TRUE(model.validation->between_rows);
    const Verdict verdict = judge(model, {});
    EXPECT_EQ(fails_any(verdict, {CriterionKind::between_rows}), every == 5) << *model.validation->between_rows;
    const bool says = std::any_of(verdict.reasons.begin(), verdict.reasons.end(), [](const std::string& reason) {
      return reason.starts_with("The rows are coarse for this input: ");
    });
    EXPECT_EQ(says, every == 5);
    EXPECT_FALSE(validate(model, rows, {}).between_rows) << "of an input that is held";
  }
}

TEST(BetweenRows, OfACutRecordAreReadNoFurtherThanItsEnd) {
  std::mt19937_64 draw(8);
  Record rows;
  rows.step_s = 0.05;
  rows.input = multisine(draw).head(800);
  rows.output = simulate(lag_model(), rows.input, rows.step_s);
  for (double& y : rows.output) y += 0.002 * normal(draw);
  Record cut = in_parts(rows, Intersample::straight);
  cut.input.conservativeResize(400 * kPartsOfARow);
  cut.output.conservativeResize(400 * kPartsOfARow);
  EXPECT_EQ(recorded_input(cut).size(), 400);
  FitOptions options;
  options.decimation = kPartsOfARow;
  const ValidationReport report = validate(lag_model(), cut, options);
  ASSERT_TRUE(report.between_rows);
  EXPECT_GT(*report.between_rows, 0.0);
  EXPECT_LT(*report.between_rows, 0.1);
}

TEST(CoarseInput, IsNoNoiseWhereItStandsStillInMostRows) {
  Eigen::VectorXd command(6000);  // 12 bits, a new value every third row
  for (Eigen::Index k = 0; k < command.size(); ++k) {
    const Eigen::Index update = k / 3;
    command[k] = 0.005 * std::round(400.0 * std::sin(0.003 * static_cast<double>(update)));
  }
  EXPECT_EQ(apparent_input_noise(command), 0.0);
  EXPECT_EQ(white_noise(command), 0.0);
}

TEST(NoisyInput, IsNoRoughExcitation) {
  for (const double kept : {0.0, 0.5, 0.9, 0.97}) {
    std::mt19937_64 draw(400);
    Eigen::VectorXd u(4000);
    double state = 0.0;
    for (double& value : u) value = state = kept * state + normal(draw);
    EXPECT_EQ(apparent_input_noise(u), 0.0) << kept;
  }
}

}  // namespace
}  // namespace eha::ident
