// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/uncertainty/bode_curve.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace eha::ident {
namespace {

const std::vector<double> kFrequencies_Hz = {0.01, 0.1, 0.5, 1.0, 4.0};

struct Case {
  std::string parameter;
  std::function<Model(double)> model;  ///< of the parameter's value
  double value;
};

Model model_of(std::vector<Term> numerator, std::vector<Term> denominator, double delay_s) {
  Model model;
  model.transfer_function = {std::move(numerator), std::move(denominator), delay_s};
  return model;
}

/// Highest order first, as a model file has it.
Model fractional(double a2, double n2, double n1, double a0, double gain, double b0, double delay_s) {
  return model_of({{gain, b0}}, {{a2, n2}, {1.0, n1}, {a0, 0.0}}, delay_s);
}

std::vector<Case> cases() {
  return {
      {"a2", [](double x) { return fractional(x, 1.75, 0.9, 0.4, 0.5, 0.2, 0.1); }, 0.6},
      {"n2", [](double x) { return fractional(0.6, x, 0.9, 0.4, 0.5, 0.2, 0.1); }, 1.75},
      {"n1", [](double x) { return fractional(0.6, 1.75, x, 0.4, 0.5, 0.2, 0.1); }, 0.9},
      {"a0", [](double x) { return fractional(0.6, 1.75, 0.9, x, 0.5, 0.2, 0.1); }, 0.4},
      {"K", [](double x) { return fractional(0.6, 1.75, 0.9, 0.4, x, 0.2, 0.1); }, 0.5},
      {"b0", [](double x) { return fractional(0.6, 1.75, 0.9, 0.4, 0.5, x, 0.1); }, 0.2},
      {"delay_s", [](double x) { return fractional(0.6, 1.75, 0.9, 0.4, 0.5, 0.2, x); }, 0.1},
      {"b1",
       [](double x) {
         return model_of({{x, 1.0}, {3.0, 0.0}}, {{0.2, 2.0}, {1.0, 1.0}, {0.5, 0.0}}, 0.0);
       },
       0.7},
      {"b0",
       [](double x) {
         return model_of({{0.7, 1.0}, {x, 0.0}}, {{0.2, 2.0}, {1.0, 1.0}, {0.5, 0.0}}, 0.0);
       },
       3.0},
      {"q",
       [](double x) {
         return model_of({{0.7, x}, {3.0, 0.0}}, {{0.2, 2.0 * x}, {1.0, x}, {0.5, 0.0}}, 0.0);
       },
       0.8},
  };
}

TEST(BodeCurve, HasTheGainAndThePhaseOfALagWithDelay) {
  const BodeCurve curve = bode_curve(model_of({{2.0, 0.0}}, {{0.1, 1.0}, {1.0, 0.0}}, 1.3), kFrequencies_Hz, {});
  for (std::size_t i = 0; i < kFrequencies_Hz.size(); ++i) {
    const double w = 2.0 * std::numbers::pi * kFrequencies_Hz[i];
    EXPECT_NEAR(curve.gain_dB[i], 20.0 * std::log10(2.0 / std::hypot(1.0, 0.1 * w)), 1e-9);
    // Many turns at 4 Hz, none of them lost.
    EXPECT_NEAR(curve.phase_deg[i], -(std::atan(0.1 * w) + 1.3 * w) * 180.0 / std::numbers::pi, 1e-9);
  }
  EXPECT_TRUE(curve.gain_std_dB.empty());
}

TEST(BodeCurve, MovesAsMuchAsItsStandardErrorSays) {
  for (const Case& c : cases()) {
    const double step = 1e-5 * c.value;
    const std::size_t terms = c.model(c.value).transfer_function.numerator.size();
    const ParameterCovariance known{{key_of(c.parameter, terms)}, Eigen::MatrixXd::Constant(1, 1, step * step)};
    const BodeCurve curve = bode_curve(c.model(c.value), kFrequencies_Hz, known);
    const BodeCurve less = bode_curve(c.model(c.value - step), kFrequencies_Hz, {});
    const BodeCurve more = bode_curve(c.model(c.value + step), kFrequencies_Hz, {});
    for (std::size_t i = 0; i < kFrequencies_Hz.size(); ++i) {
      const double gain = std::abs(more.gain_dB[i] - less.gain_dB[i]) / 2.0;
      const double phase = std::abs(more.phase_deg[i] - less.phase_deg[i]) / 2.0;
      EXPECT_NEAR(curve.gain_std_dB[i], gain, 1e-5 * gain + 1e-11) << c.parameter << " at " << kFrequencies_Hz[i];
      EXPECT_NEAR(curve.phase_std_deg[i], phase, 1e-5 * phase + 1e-10) << c.parameter << " at " << kFrequencies_Hz[i];
    }
  }
}

TEST(BodeCurve, LosesWhatCorrelatedErrorsCancel) {
  // K and a0 wrong by the same share: the static gain stays.
  ParameterCovariance known{{numerator_key(0, 1), coefficient_key(0)}, Eigen::MatrixXd(2, 2)};
  known.matrix << 0.25, 0.2, 0.2, 0.16;
  const Model model = fractional(0.6, 1.75, 0.9, 0.4, 0.5, 0.0, 0.0);
  const BodeCurve curve = bode_curve(model, std::vector<double>{1e-6, 1.0}, known);
  EXPECT_LT(curve.gain_std_dB[0], 0.01);
  EXPECT_GT(curve.gain_std_dB[1], 1.0);
}

}  // namespace
}  // namespace eha::ident
