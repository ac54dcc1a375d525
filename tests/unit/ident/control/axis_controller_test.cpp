// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "core/error.hpp"
#include "ident/control/axis_design.hpp"

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

AxisSettings settings() {
  AxisSettings s;
  s.tick_s = 0.001;
  s.feedback = {.kp = 15.0, .filter_s = 0.005};
  s.rest_error = 0.002;
  s.tracking_s = 0.3;
  s.most_speed = 0.6;
  s.inverse = {.null = -0.2, .dead_band = 0.15, .gain_positive = 0.15, .gain_negative = 0.13, .smoothing = 0.03};
  s.feed_forward = {.acceleration_s = 0.007};
  s.reference = {.lowest = 0.0, .highest = 6.0, .velocity = 0.4, .acceleration = 1.0, .jerk = 25.0};
  s.command_min = -5.0;
  s.command_max = 5.0;
  s.slew_per_s = 20.0;
  return s;
}

TEST(InverseMap, AndItsInverseGiveTheSpeedBack) {
  const InverseMap map = settings().inverse;
  for (double w = -0.5; w <= 0.5; w += 0.0007) EXPECT_NEAR(map.speed(map.command(w)), w, 1e-13) << w;
  // Beyond the smoothing the valve passes exactly the speed: v = gain (u - null -+ dead band).
  EXPECT_NEAR(0.15 * (map.command(0.3) - map.null - map.dead_band), 0.3, 1e-13);
  EXPECT_NEAR(0.13 * (map.command(-0.3) - map.null + map.dead_band), -0.3, 1e-13);
}

TEST(AxisController, KeepsTheReferenceWithinItsLimitsForAnySetPoint) {
  const AxisSettings s = settings();
  std::mt19937_64 random(3);
  AxisController controller(coefficients(s));
  controller.start(3.0, 0.0);
  double set_point = 3.0;
  double r = 3.0;
  double v = 0.0;
  double a = 0.0;
  for (int i = 0; i < 60000; ++i) {
    const auto draw = random() % 1000;
    if (draw == 0) set_point = 8.0 * static_cast<double>(random() % 1000) / 1000.0 - 1.0;
    if (draw > 990) set_point += 0.0002;
    const AxisOutput out = controller.step(draw == 5 ? kNaN : set_point, r);
    const double velocity = (out.reference - r) / s.tick_s;
    ASSERT_LE(std::abs(velocity), s.reference.velocity * (1 + 1e-6)) << i;
    ASSERT_LE(std::abs(out.acceleration), s.reference.acceleration * (1 + 1e-6)) << i;
    ASSERT_LE(std::abs(out.acceleration - a) / s.tick_s, s.reference.jerk * (1 + 1e-6)) << i;
    // A set point that runs into the end of the travel at speed: the way to stop from there.
    const double way = s.reference.velocity * s.reference.velocity / (2.0 * s.reference.acceleration);
    ASSERT_GE(out.reference, s.reference.lowest - way);
    ASSERT_LE(out.reference, s.reference.highest + way);
    ASSERT_NEAR(velocity, v, 1e-9 + s.reference.acceleration * s.tick_s) << i;
    r = out.reference;
    v = out.velocity;
    a = out.acceleration;
  }
}

TEST(AxisController, ReachesASetPointAndStaysThere) {
  AxisController controller(coefficients(settings()));
  controller.start(3.0, -0.2);
  AxisOutput out;
  double highest = 0.0;
  for (int i = 0; i < 4000; ++i) {
    out = controller.step(3.5, out.reference > 0.0 ? out.reference : 3.0);
    highest = std::max(highest, out.reference);
  }
  EXPECT_NEAR(out.reference, 3.5, 1e-9);
  EXPECT_NEAR(highest, 3.5, 1e-6);
  EXPECT_NEAR(out.velocity, 0.0, 1e-9);
}

TEST(AxisController, FollowsASetPointThatMovesWithinTheLimitsWithTheDelayOfItsMeanAlone) {
  const AxisSettings s = settings();
  const AxisCoefficients c = coefficients(s);
  AxisController controller(c);
  controller.start(3.0, -0.2);
  const double late_s = (0.5 * static_cast<double>(c.taps - 1)) * s.tick_s;
  const double w = 2.0 * std::numbers::pi * 0.3;
  const auto wave = [&](double t) { return 3.0 + 0.05 * (1.0 - std::cos(w * t)); };
  for (int i = 0; i < 8000; ++i) {
    const double t = i * s.tick_s;
    const AxisOutput out = controller.step(wave(t), wave(t - late_s));
    if (t > 1.0) {
      ASSERT_NEAR(out.reference, wave(t - late_s), 5e-4) << t;
      ASSERT_NEAR(out.velocity, 0.05 * w * std::sin(w * (t - late_s)), 5e-3) << t;
    }
  }
}

TEST(AxisController, BeginsWithoutABump) {
  for (const double ki : {0.0, 40.0}) {
    AxisSettings s = settings();
    s.feedback.ki = ki;
    AxisController controller(coefficients(s));
    controller.start(2.5, 0.7);
    const AxisOutput out = controller.step(2.5, 2.5);
    EXPECT_LE(std::abs(out.command - 0.7), s.slew_per_s * s.tick_s * (1 + 1e-9)) << ki;
    EXPECT_EQ(out.reference, 2.5);
    if (ki > 0.0) {
      EXPECT_NEAR(out.command, 0.7, 1e-9);
    }
  }
}

/// The farthest from 2.9 in that a rod goes within 20 s after a reading of one tick that is none of it.
double farthest_after(double reading, bool at_the_start) {
  AxisSettings s = settings();
  s.feedback.ki = 60.0;
  AxisController controller(coefficients(s));
  double rod = 2.9;
  controller.start(at_the_start ? reading : rod, s.inverse.null);
  double farthest = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double command = controller.step(2.9, i == 1000 && !at_the_start ? reading : rod).command;
    rod += s.tick_s * s.inverse.speed(command);
    farthest = std::max(farthest, std::abs(rod - 2.9));
  }
  EXPECT_NEAR(rod, 2.9, 0.02) << reading;
  return farthest;
}

TEST(AxisController, IsNotCarriedAwayByOneReadingThatIsNoneOfTheRod) {
  for (const double reading : {65535.0, -32768.0, 1e12, 1e308, -1e308, kNaN}) {
    EXPECT_LT(farthest_after(reading, false), 0.1) << reading;
  }
  const AxisSettings s = settings();
  const double reach = std::max(s.reference.highest - 2.9, 2.9 - s.reference.lowest);
  for (const double reading : {65535.0, 73.66, -32768.0, 1e17}) {
    EXPECT_LT(farthest_after(reading, true), reach) << reading;
  }
  for (const double none : {kNaN, std::numeric_limits<double>::infinity()}) {
    EXPECT_LT(farthest_after(none, true), 0.01) << none;
  }
}

TEST(AxisController, KeepsRangeAndSlewWhateverIsRead) {
  AxisSettings s = settings();
  s.feedback.ki = 60.0;
  s.feedback.kd = 0.2;
  AxisController controller(coefficients(s));
  controller.start(3.0, 0.0);
  std::mt19937_64 random(5);
  double last = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double reading = i % 97 == 0 ? kNaN : i % 89 == 0 ? 1e300 : static_cast<double>(random() % 6000) / 1000.0;
    const double set_point = i % 101 == 0 ? std::numeric_limits<double>::infinity() : 3.0;
    const double command = controller.step(set_point, reading).command;
    ASSERT_TRUE(std::isfinite(command)) << i;
    ASSERT_GE(command, s.command_min);
    ASSERT_LE(command, s.command_max);
    ASSERT_LE(std::abs(command - last), s.slew_per_s * s.tick_s * (1 + 1e-9)) << i;
    last = command;
  }
}

TEST(AxisController, DoesNotWindUpWhileTheRodIsStuck) {
  AxisSettings s = settings();
  s.feedback.ki = 60.0;
  AxisController controller(coefficients(s));
  controller.start(3.0, -0.2);
  for (int i = 0; i < 20000; ++i) static_cast<void>(controller.step(5.0, 3.0));
  // The rod is free and already beyond: the command turns within what error and slew ask for.
  int ticks = 0;
  while (controller.step(5.0, 5.2).command > -0.2 && ticks < 2000) ++ticks;
  EXPECT_LT(ticks, 500);
}

/// Response of the controller to an impulse of the error, with an inverse that passes the speed.
TEST(SampledFeedback, IsWhatTheControllerDoes) {
  for (const FeedbackKind kind : {FeedbackKind::p, FeedbackKind::pid, FeedbackKind::fopid}) {
    AxisSettings s = settings();
    s.kind = kind;
    s.rest_error = 0.0;
    s.feedback = {.kp = 12.0, .filter_s = 0.006};
    if (kind != FeedbackKind::p) {
      s.feedback.ki = 50.0;
      s.feedback.kd = 0.3;
    }
    if (kind == FeedbackKind::fopid) {
      s.feedback.integral_order = 0.8;
      s.feedback.derivative_order = 0.9;
    }
    s.inverse = {.null = 0.0, .dead_band = 0.0, .gain_positive = 1.0, .gain_negative = 1.0, .smoothing = 1.0};
    s.command_min = -1e6;
    s.command_max = 1e6;
    s.most_speed = 1e6;
    s.slew_per_s = 1e9;
    const AxisCoefficients c = coefficients(s);
    AxisController controller(c);
    controller.start(3.0, 0.0);
    // A sine of the reading, after its transient: the command by its Fourier coefficient over whole periods.
    const double w = 2.0 * std::numbers::pi * 20.0;
    const int period = 50;
    const int skipped = 400 * period;
    Complex sum = 0.0;
    Complex offset = 0.0;
    const int count = 200 * period;
    for (int i = 0; i < skipped + count; ++i) {
      const double error = std::sin(w * i * s.tick_s);
      const double command = controller.step(3.0, 3.0 - error).command;
      if (i >= skipped) sum += command * std::polar(1.0, -w * i * s.tick_s);
    }
    const Complex measured = 2.0 * sum / static_cast<double>(count) * Complex(0.0, 1.0) + offset;
    const Complex expected = sampled_feedback(c, w);
    EXPECT_LT(std::abs(measured - expected), 2e-3 * std::abs(expected)) << text(kind);
  }
}

TEST(FractionalFilter, IsThePowerOfSWithinItsBand) {
  const double tick_s = 0.001;
  for (const double order : {-0.5, -0.2, 0.3, 0.5}) {
    const FractionalFilter f = fractional_filter(order, 0.03, std::numbers::pi / tick_s, tick_s);
    for (const double w : {0.5, 3.0, 30.0}) {
      const Complex late = std::polar(1.0, -w * tick_s);
      Complex value = f.direct;
      for (std::size_t i = 0; i < f.count; ++i)
        value += f.gain[i] * (1.0 - f.pole[i]) * late / (1.0 - f.pole[i] * late);
      const Complex exact = std::pow(Complex(0.0, w), order);
      EXPECT_LT(std::abs(value / exact - 1.0), 0.06) << order << " at " << w;
    }
  }
}

TEST(SampledPlant, IsTheHeldPlantSampled) {
  // K / (s + a) held: K/a (1 - q) / (z - q), q = e^(-a h); a whole tick of delay: times 1/z.
  const double a = 30.0;
  const double h = 0.004;
  const TransferFunction g{{{2.0, 0}}, {{1.0, 1}, {a, 0}}, 0.0};
  const double q = std::exp(-a * h);
  for (const double w : {0.1, 5.0, 60.0, 300.0}) {
    const Complex z = std::polar(1.0, w * h);
    const Complex exact = 2.0 / a * (1.0 - q) / (z - q);
    EXPECT_LT(std::abs(sampled_plant(g, h, 0.0, w) / exact - 1.0), w < 100.0 ? 5e-3 : 0.03) << w;
    EXPECT_LT(std::abs(sampled_plant(g, h, h, w) * z / sampled_plant(g, h, 0.0, w) - 1.0), 1e-9) << w;
  }
}

TEST(InverseExpansion, OfWholeOrdersIsThePowerSeries) {
  // G = (1 + 0.5 s) e^(-0.1 s) / (2 + 3 s + 4 s^2).
  const TransferFunction g{{{0.5, 1}, {1, 0}}, {{4, 2}, {3, 1}, {2, 0}}, 0.1};
  const auto inverse = inverse_expansion(g, {0.01, 1.0});
  ASSERT_TRUE(inverse);
  for (const double s : {1e-3, -1e-3}) {
    const double exact = 1.0 / frequency_response(g, Complex(s, 0.0)).real();
    EXPECT_NEAR(inverse->position + s * inverse->velocity + s * s * inverse->acceleration, exact, 1e-8);
  }
  EXPECT_FALSE(inverse_expansion({{{1, 1}}, {{1, 2}, {1, 0}}, 0.0}, {0.01, 1.0}));
  EXPECT_FALSE(inverse_expansion({{{-1, 0}}, {{0.1, 2}, {1, 1}}, 0.0}, {0.01, 1.0}));
}

Model rod() {
  Model model;
  model.name = "rod";
  model.input_map = ValveMap{-0.2, 0.15, 0.88};
  model.transfer_function = {{{0.15, 0}}, {{0.0065, 2}, {1, 1}}, 0.0};
  model.initial_output = 2.95;
  return model;
}

AxisTask task() {
  AxisTask task;
  task.lowest = 0.15;
  task.highest = 5.75;
  task.velocity_limit = 8.0;
  task.noise = 0.0006;
  task.lsb = 0.0002;
  return task;
}

TEST(AxisDesign, KeepsItsLimitsOverTheDraws) {
  const AxisPlant plant = axis_plant(rod(), task());
  EXPECT_EQ(plant.draws.size(), 200U);
  EXPECT_NEAR(plant.inverse.acceleration, 0.0065, 1e-12);
  for (const FeedbackKind kind : {FeedbackKind::p, FeedbackKind::pi, FeedbackKind::pd}) {
    const auto design = design_axis(plant, task(), kind);
    ASSERT_TRUE(design) << text(kind);
    EXPECT_LE(design->margins.peak95, 1.4) << text(kind);
    EXPECT_LE(design->margins.ms.upper, 1.4) << text(kind) << ": the bound that is shown";
    EXPECT_LE(design->margins.mt.upper, 1.4) << text(kind);
    EXPECT_EQ(design->margins.stable_share, 1.0);
    EXPECT_LE(design->margins.ms.lower, design->margins.ms.value);
    EXPECT_GE(design->margins.ms.upper, design->margins.ms.value);
    EXPECT_LE(design->feedback.noise_share, 1.0 + 1e-6) << text(kind);
    const CommandNoise noise = command_noise(design->settings, task().noise);
    EXPECT_LE(noise.change_rms, 20.0 * 0.001);
    EXPECT_LE(noise.rms, 0.02 * 10.0);
  }
}

TEST(AxisDesign, OfANoisySensorIsSlower) {
  AxisTask noisy = task();
  noisy.noise *= 20.0;
  const auto quiet = design_axis(axis_plant(rod(), task()), task(), FeedbackKind::p);
  const auto loud = design_axis(axis_plant(rod(), noisy), noisy, FeedbackKind::p);
  ASSERT_TRUE(quiet && loud);
  EXPECT_LT(loud->settings.feedback.kp, 0.9 * quiet->settings.feedback.kp);
  EXPECT_GT(loud->settings.feedback.filter_s, quiet->settings.feedback.filter_s);
}

TEST(CommandNoise, IsThatOfTheControllerOnWhiteReadings) {
  AxisSettings s = settings();
  s.inverse.smoothing = 1.0;  // no reading leaves the slope about the null
  s.inverse.gain_negative = s.inverse.gain_positive;
  s.slew_per_s = 1e9;
  s.most_speed = 1e3;
  const double noise = 0.0006;
  AxisController controller(coefficients(s));
  controller.start(3.0, -0.2);
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal(0.0, noise);
  double sum = 0.0;
  double changes = 0.0;
  double last = -0.2;
  const int count = 200000;
  for (int i = 0; i < count; ++i) {
    const double command = controller.step(3.0, 3.0 + normal(random)).command;
    sum += (command + 0.2) * (command + 0.2);
    changes += (command - last) * (command - last);
    last = command;
  }
  const CommandNoise predicted = command_noise(s, noise);
  EXPECT_NEAR(std::sqrt(sum / count), predicted.rms, 0.05 * predicted.rms);
  EXPECT_NEAR(std::sqrt(changes / count), predicted.change_rms, 0.05 * predicted.change_rms);
}

TEST(AxisPlant, IsRefusedForAModelThatNoControllerSuits) {
  Model growing = rod();
  growing.transfer_function.denominator = {{1, 2}, {-1, 1}};
  EXPECT_THROW(static_cast<void>(axis_plant(growing, task())), DataError);
  Model reversed = rod();
  reversed.transfer_function.numerator[0].coefficient = -0.15;
  EXPECT_THROW(static_cast<void>(axis_plant(reversed, task())), DataError);
}

TEST(AxisCoefficients, OfSettingsThatMakeNoSenseAreRefused) {
  const auto refused = [](auto change) {
    AxisSettings s = settings();
    change(s);
    EXPECT_THROW(static_cast<void>(coefficients(s)), ConfigError);
  };
  refused([](AxisSettings& s) { s.feedback.kp = -1.0; });
  refused([](AxisSettings& s) { s.feedback.kp = kNaN; });
  refused([](AxisSettings& s) { s.inverse.gain_negative = 0.0; });
  refused([](AxisSettings& s) { s.reference.jerk = 1e-3; });
  refused([](AxisSettings& s) { s.command_max = s.command_min; });
  refused([](AxisSettings& s) { s.command_max = s.inverse.null; });
  refused([](AxisSettings& s) { s.command_min = s.inverse.null - 0.5 * s.inverse.dead_band; });
  refused([](AxisSettings& s) {
    s.feedback.ki = 1.0;
    s.tracking_s = 0.0;
  });
}

}  // namespace
}  // namespace eha::ident
