// SPDX-License-Identifier: GPL-3.0-or-later
// Margins of loops that are known in closed form, and optima computed elsewhere.
#include "ident/control/feedback_design.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

constexpr int kFine = 2000;

PlantResponse four_lags(int points = kFine) {
  return sampled_response([](double w) { return 1.0 / std::pow(Complex(1.0, w), 4); }, 1e-3, 1e3, 0.0, points);
}

PlantResponse delayed() {
  return sampled_response([](double w) { return std::polar(1.0, -w) / std::pow(Complex(1.0, 0.05 * w), 2); }, 1e-3, 1e3,
                          0.0, 6 * kFine);
}

PlantResponse spread_lags() {
  return sampled_response(
      [](double w) {
        return 1.0 / (Complex(1.0, w) * Complex(1.0, 0.1 * w) * Complex(1.0, 0.01 * w) * Complex(1.0, 0.001 * w));
      },
      1e-3, 1e5, 0.0, kFine);
}

TEST(LoopMargins, OfAnIntegratorWithALagAreThoseOfItsClosedForm) {
  // L = k / (s (s + 1)), k = sqrt 2: |L| = 1 at w = 1, arg L = -135 degrees.
  const double k = std::numbers::sqrt2;
  const PlantResponse plant =
      sampled_response([](double w) { return 1.0 / (Complex(0.0, w) * Complex(1.0, w)); }, 1e-4, 1e4, 1.0, 4000);
  const LoopMargins m = loop_margins(plant.w_rad_s, open_loop(plant, {.kp = k}), 1.0);
  ASSERT_TRUE(m.is_stable);
  EXPECT_NEAR(m.phase_deg, 45.0, 1e-3);
  EXPECT_NEAR(m.crossover_rad_s, 1.0, 1e-4);
  EXPECT_NEAR(m.delay_s, 0.25 * std::numbers::pi, 1e-4);
  EXPECT_TRUE(std::isinf(m.gain));
  // T = k / (s^2 + s + k): damping 1 / (2 sqrt k).
  const double damping = 0.5 / std::sqrt(k);
  EXPECT_NEAR(m.mt, 1.0 / (2.0 * damping * std::sqrt(1.0 - damping * damping)), 1e-5);
}

TEST(LoopMargins, OfThreeLagsHaveTheGainMarginOfRouth) {
  // k / (s + 1)^3 is stable below k = 8.
  const PlantResponse plant =
      sampled_response([](double w) { return 1.0 / std::pow(Complex(1.0, w), 3); }, 1e-3, 1e3, 0.0);
  const LoopMargins m = loop_margins(plant.w_rad_s, open_loop(plant, {.kp = 2.0}), 0.0);
  ASSERT_TRUE(m.is_stable);
  EXPECT_NEAR(m.gain, 4.0, 1e-2);
  EXPECT_FALSE(loop_margins(plant.w_rad_s, open_loop(plant, {.kp = 8.1}), 0.0).is_stable);
  EXPECT_TRUE(loop_margins(plant.w_rad_s, open_loop(plant, {.kp = 7.9}), 0.0).is_stable);
}

TEST(FeedbackDesign, ReachesTheGreatestIntegralGainOfPI) {
  struct Reference {
    const char* what;
    PlantResponse plant;
    double ki;
    double kp;
  };
  for (const Reference& r : {Reference{"four lags", four_lags(), 0.1919, 0.426},
                             {"delay", delayed(), 0.4319, 0.154},
                             {"spread lags", spread_lags(), 8.52, 4.33}}) {
    const auto design = design_feedback(FeedbackKind::pi, r.plant, {.sensitivity = 1.4});
    ASSERT_TRUE(design) << r.what;
    EXPECT_NEAR(design->feedback.ki, r.ki, 0.01 * r.ki) << r.what;
    EXPECT_NEAR(design->feedback.kp, r.kp, 0.05 * r.kp)  // the optimum is flat
        << r.what;
    EXPECT_LE(design->sensitivity, 1.4) << r.what;
    EXPECT_GT(design->sensitivity, 1.3999) << r.what;
  }
}

TEST(FeedbackDesign, OfPIDKeepsTheLimitAndGainsOnPI) {
  const PlantResponse plant = four_lags();
  const auto pi = design_feedback(FeedbackKind::pi, plant, {.sensitivity = 1.4});
  const auto pid = design_feedback(FeedbackKind::pid, plant, {.sensitivity = 1.4});
  ASSERT_TRUE(pi && pid);
  EXPECT_LE(pid->sensitivity, 1.4);
  EXPECT_GT(pid->feedback.ki, 2.0 * pi->feedback.ki);
}

/// RMS of what white noise of the measurement does to the command, without the integral part.
double noise_of(const PlantResponse& plant, Feedback c) {
  c.ki = 0.0;
  double sum = 0.0;
  for (std::size_t i = 1; i < plant.w_rad_s.size(); ++i) {
    sum += std::norm(frequency_response(c, Complex(0.0, plant.w_rad_s[i]))) * (plant.w_rad_s[i] - plant.w_rad_s[i - 1]);
  }
  return std::sqrt(sum);
}

/// RMS error of the best PID over that of the best FOPID of the same filter, margins and noise.
double gain_of_fractional_orders(const PlantResponse& plant) {
  constexpr double kFilter_s = 0.02;
  const auto pid =
      design_feedback(FeedbackKind::pid, plant, {.sensitivity = 1.4}, kFilter_s, DesignCriterion::squared_error);
  if (!pid) return 0.0;
  const double noise = noise_of(plant, pid->feedback);
  const auto share = [&](const Feedback& c) { return noise_of(plant, c) / noise; };
  const auto fopid = design_feedback(FeedbackKind::fopid, plant, {.sensitivity = 1.4, .noise_share = share}, kFilter_s);
  if (!fopid) return 0.0;
  EXPECT_LE(fopid->sensitivity, 1.4);
  EXPECT_LE(fopid->noise_share, 1.0);
  return std::sqrt(pid->squared_error / fopid->squared_error);
}

TEST(FeedbackDesign, OfFractionalOrdersGainsOnAFractionalPlantAndNotEnoughOnFourLags) {
  const PlantResponse fractional = sampled_response(
      [](double w) {
        const Complex s(0.0, w);
        return std::exp(-0.1 * s) / std::pow(s, 1.4);
      },
      1e-4, 1e3, 1.4, 300);
  EXPECT_GT(gain_of_fractional_orders(fractional), kFractionalIsWorth);
  const PlantResponse lags =
      sampled_response([](double w) { return 1.0 / std::pow(Complex(1.0, w), 4); }, 1e-4, 1e3, 0.0, 300);
  EXPECT_LT(gain_of_fractional_orders(lags), kFractionalIsWorth);
}

TEST(FeedbackDesign, KeepsALimitOnTheNoise) {
  const PlantResponse plant = four_lags(600);
  const auto share = [](const Feedback& c) { return c.kp / 0.2; };
  const auto design = design_feedback(FeedbackKind::pi, plant, {.sensitivity = 1.4, .noise_share = share});
  ASSERT_TRUE(design);
  EXPECT_LE(design->feedback.kp, 0.2);
  EXPECT_LE(design->noise_share, 1.0);
}

}  // namespace
}  // namespace eha::ident
