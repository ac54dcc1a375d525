// SPDX-License-Identifier: GPL-3.0-or-later
// The bounds of closed loops, on a rod that is a line.
#include "daemon/place/loop_monitor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <utility>

#include "tests/unit/place/long_play.hpp"

namespace eha::place {
namespace {

using acquisition::Fault;

constexpr double kTick_s = 0.001;

/// The shipped card's limits, with a valve of 1.2 in/(V s).
config::RigLimits limits() {
  config::RigLimits limits = limits_of_the_simulated_rig();
  limits.following = config::Following{
      .gain_positive_in_per_V_s = 0.6, .gain_negative_in_per_V_s = 0.6, .null_V = 0.1, .dead_band_V = 0.3};
  return limits;
}

/// Asks for volts of the time; the rod moves as the command says. @returns the time of the fault [s], or 0
double fault_at(LoopMonitor& monitor, const std::function<double(double)>& wanted_V_at, double time_s,
                const std::function<double(double)>& speed_of, double noise_in = 0.0) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, 1.0);
  double place_in = 3.0;
  for (int k = 0; k < static_cast<int>(time_s / kTick_s); ++k) {
    const hal::RigReading reading{.displacement_in = place_in + noise_in * noise(random)};
    const double command_V = monitor.bounded_V(wanted_V_at(k * kTick_s), reading);
    if (monitor.breach().fault != Fault::none) return k * kTick_s;
    place_in += kTick_s * speed_of(command_V);
  }
  return 0.0;
}

/// The same with a constant voltage.
double fault_at(LoopMonitor& monitor, double wanted_V, double time_s, const std::function<double(double)>& speed_of,
                double noise_in = 0.0) {
  return fault_at(
      monitor, [&](double) { return wanted_V; }, time_s, speed_of, noise_in);
}

/// The valve of limits().
double sound(double command_V) {
  const double off_V = command_V - 0.1;
  return 1.2 * std::copysign(std::max(0.0, std::abs(off_V) - 0.25), off_V);
}

TEST(LoopBounds, AreAThirdOfTheRangeUnlessTheFileNamesMore) {
  config::RigLimits wide = limits();
  EXPECT_DOUBLE_EQ(loop_bounds(wide).most_V, 1.5);
  EXPECT_NEAR(loop_bounds(wide, 0.3).most_V, 0.25 + 0.25 + 0.3, 1e-12) << "what the speed needs";
  wide.following->gain_negative_in_per_V_s = 0.0236;  // mm for in
  EXPECT_DOUBLE_EQ(loop_bounds(wide, 0.3).most_V, 1.5);
  wide.closed_loop_max_V = 2.5;
  EXPECT_DOUBLE_EQ(loop_bounds(wide, 0.3).most_V, 2.5);
  wide.following.reset();
  EXPECT_DOUBLE_EQ(loop_bounds(wide, 0.3).most_V, 2.5);
}

/// A fast rod may have a low velocity limit, and gains in the file that are ten times too small.
TEST(LoopBounds, GrowNoFasterForALowVelocityLimitOrAWideRange) {
  config::RigLimits slow = limits();
  EXPECT_NEAR(loop_bounds(slow, 0.3).growth_V_per_s, 0.8, 1e-12);
  slow.velocity_limit_in_per_s = 1.0;
  EXPECT_NEAR(loop_bounds(slow, 0.1).growth_V_per_s, 0.8, 1e-12);
  slow.command_min_V = -10.0;
  slow.command_max_V = 10.0;
  EXPECT_NEAR(loop_bounds(slow, 0.1).growth_V_per_s, 0.8, 1e-12);
}

TEST(LoopMonitor, KeepsTheCommandAboutTheNullAndLetsItGrowSlowly) {
  constexpr double kAtOnce_V = 0.25 + 0.1 / 1.2;  // the dead band, and what gives 0.1 in/s
  LoopMonitor monitor(loop_bounds(limits(), 0.3), kTick_s);
  hal::RigReading reading{.displacement_in = 3.0};
  EXPECT_NEAR(monitor.bounded_V(9.0, reading), 0.1 + kAtOnce_V, 0.002) << "the dead band at once";
  double before_V = monitor.bounded_V(9.0, reading);
  for (int k = 0; k < 100; ++k) {
    const double command_V = monitor.bounded_V(9.0, reading);
    EXPECT_LE(command_V - before_V, 1.3 / (8.0 / 5.0) * kTick_s + 1e-12);
    before_V = command_V;
  }
  EXPECT_NEAR(monitor.bounded_V(0.1, reading), 0.1, 1e-12) << "back at once";
  EXPECT_NEAR(monitor.bounded_V(-9.0, reading), 0.1 - kAtOnce_V, 0.002);
}

TEST(LoopMonitor, WaitsAtTheNullWhileThePressureBuildsUp) {
  config::RigLimits slow = limits();
  slow.following->pressure_delay_s = 0.2;
  LoopMonitor monitor(loop_bounds(slow, 0.3), kTick_s);
  const hal::RigReading reading{.displacement_in = 3.0};
  for (int k = 0; k < 199; ++k) ASSERT_DOUBLE_EQ(monitor.bounded_V(9.0, reading), 0.1) << k;
  for (int k = 0; k < 3; ++k) (void)monitor.bounded_V(9.0, reading);
  EXPECT_GT(monitor.bounded_V(9.0, reading), 0.3);
}

TEST(LoopMonitor, LetsASoundRodMoveWithEveryNoise) {
  for (const double noise_in : {0.0, 0.0005, 0.002, 0.006}) {
    LoopMonitor monitor(loop_bounds(limits(), 0.3), kTick_s);
    EXPECT_EQ(fault_at(monitor, 0.6, 5.0, sound, noise_in), 0.0) << noise_in << to_text(monitor.breach().fault);
  }
}

TEST(LoopMonitor, TripsOnARodThatIsMuchFasterThanTheLoopMeans) {
  LoopMonitor monitor(loop_bounds(limits(), 0.3), kTick_s);
  const double at_s = fault_at(
      monitor, 9.0, 5.0, [](double u) { return 4.0 * sound(u); }, 0.002);
  EXPECT_EQ(monitor.breach().fault, Fault::loop_speed);
  EXPECT_GT(at_s, 0.0);
  EXPECT_GT(monitor.breach().value, 0.75);
  EXPECT_LT(monitor.breach().value, 1.0);
}

TEST(LoopMonitor, TripsOnARodThatDoesNotMoveThroughAnyNoise) {
  for (const double noise_in : {0.0, 0.0005, 0.002, 0.006}) {
    LoopMonitor monitor(loop_bounds(limits(), 0.3), kTick_s);
    const double at_s = fault_at(
        monitor, 9.0, 5.0, [](double) { return 0.0; }, noise_in);
    EXPECT_EQ(monitor.breach().fault, Fault::no_motion) << noise_in;
    EXPECT_GT(at_s, 0.1) << noise_in;
    EXPECT_LT(at_s, 0.8) << noise_in;
  }
}

/// By the gain of the file, not by the least that the velocity limit asks for: that took 0.44 s.
TEST(LoopMonitor, FindsADeadSensorOfAFastRodSoon) {
  LoopMonitor monitor(loop_bounds(limits(), 0.3), kTick_s);
  const double at_s = fault_at(
      monitor, 9.0, 5.0, [](double) { return 0.0; }, 0.0005);
  EXPECT_EQ(monitor.breach().fault, Fault::no_motion);
  EXPECT_LT(at_s, 0.35);
}

/// Motion of 0.015 in a tick is no noise: taken for it, it let the rod pass for 0.7 s.
TEST(LoopMonitor, FindsASensorThatFreezesInMotionAtTheLongestTickSoon) {
  constexpr double kLongTick_s = 0.05;
  constexpr double kFreezes_s = 3.0;
  LoopMonitor monitor(loop_bounds(limits(), 0.3), kLongTick_s);
  double place_in = 2.0;
  double at_s = 0.0;
  for (; at_s < 10.0 && monitor.breach().fault == Fault::none; at_s += kLongTick_s) {
    const double command_V = monitor.bounded_V(0.6, {.displacement_in = place_in});
    if (at_s < kFreezes_s) place_in += kLongTick_s * sound(command_V);
  }
  // The way that lacks may be summed up before the filter at this tick shows that there is none.
  EXPECT_TRUE(monitor.breach().fault == Fault::no_motion || monitor.breach().fault == Fault::wrong_speed);
  EXPECT_GT(at_s, kFreezes_s);
  EXPECT_LT(at_s - kFreezes_s, 0.6);
}

/// A wire that opened picks up the mains, at the Nyquist frequency of a tick of 10 ms.
TEST(LoopMonitor, FindsADeadSensorThatHums) {
  constexpr double kLongTick_s = 0.01;
  LoopMonitor monitor(loop_bounds(limits(), 0.3), kLongTick_s);
  double time_s = 0.0;
  for (int k = 0; monitor.breach().fault == Fault::none && time_s < 10.0; ++k) {
    const hal::RigReading reading{.displacement_in = 3.0 + (k % 2 == 0 ? 0.05 : -0.05)};
    static_cast<void>(monitor.bounded_V(9.0, reading));
    time_s = k * kLongTick_s;
  }
  EXPECT_EQ(monitor.breach().fault, Fault::no_motion);
  EXPECT_LT(time_s, 0.8);
}

TEST(LoopMonitor, TripsOnASpeedThatIsNotThatOfTheVolts) {
  for (const auto& [factor, wanted_V] : {std::pair(0.5, 0.9), std::pair(2.2, 0.6)}) {
    LoopMonitor monitor(loop_bounds(limits(), 0.3), kTick_s);
    const double of_sound = factor;
    const double at_s = fault_at(
        monitor, wanted_V, 5.0, [&](double u) { return of_sound * sound(u); }, 0.0005);
    EXPECT_EQ(monitor.breach().fault, Fault::wrong_speed) << factor;
    EXPECT_GT(at_s, 0.5) << factor;
    EXPECT_LT(at_s, 1.5) << factor;
  }
  for (const double factor : {0.75, 1.4}) {
    LoopMonitor monitor(loop_bounds(limits(), 0.3), kTick_s);
    EXPECT_EQ(fault_at(
                  monitor, 0.6, 5.0, [&](double u) { return factor * sound(u); }, 0.0005),
              0.0)
        << factor;
  }
}

/// A wire that catches hold again after 0.4 s: each moment of half a second has speeds that are right.
TEST(LoopMonitor, TripsOnASensorThatSlipsInJerks) {
  LoopMonitor monitor(loop_bounds(limits(), 0.3), kTick_s);
  const auto shown = [&, tick = 0](double u) mutable { return (++tick % 800 < 400 ? 0.1 : 1.0) * sound(u); };
  const double at_s = fault_at(monitor, 0.6, 10.0, shown, 0.0005);
  EXPECT_EQ(monitor.breach().fault, Fault::wrong_speed);
  EXPECT_GT(at_s, 0.0);
  EXPECT_LT(at_s, 3.0);
}

/// Volts of a sweep: beyond the dead band by 0.2 V, less and more in turn.
double swept_V(double time_s) { return 0.1 + 0.25 + 0.2 + 0.08 * std::sin(2.0 * std::numbers::pi * 1.2 * time_s); }

LoopMonitor monitor_of_a_trial() {
  LoopBounds bounds = loop_bounds(limits(), 0.75);
  bounds.growth_V_per_s = std::numeric_limits<double>::infinity();
  bounds.compares_slope = true;
  return {bounds, kTick_s};
}

/// A null that is wrong by 0.02 V makes up for a part of the speed that is missing, but not of its slope.
TEST(LoopMonitor, TripsOnASlopeThatHalvedInASweep) {
  for (const double noise_in : {0.0, 0.0015}) {
    LoopMonitor monitor = monitor_of_a_trial();
    const double at_s = fault_at(
        monitor, swept_V, 5.0, [](double u) { return 0.5 * sound(u + 0.02); }, noise_in);
    EXPECT_EQ(monitor.breach().fault, Fault::wrong_speed) << noise_in;
    EXPECT_GT(at_s, 0.3) << noise_in;
    EXPECT_LT(at_s, 1.5) << noise_in;
  }
}

TEST(LoopMonitor, LetsASoundRodSweepWithAWrongNullAndAFlatteningValve) {
  const auto flattening = [](double u) { return 0.3 * std::tanh(sound(u) / 0.3); };
  for (const double noise_in : {0.0, 0.0015, 0.006}) {
    LoopMonitor off = monitor_of_a_trial();
    EXPECT_EQ(fault_at(
                  off, swept_V, 20.0, [](double u) { return 0.9 * sound(u - 0.03); }, noise_in),
              0.0)
        << noise_in;
    LoopMonitor flat = monitor_of_a_trial();
    EXPECT_EQ(fault_at(flat, swept_V, 20.0, flattening, noise_in), 0.0) << noise_in;
  }
}

TEST(LoopMonitor, LooksAtALoopAboutATableOnlyWhileItIsSaturated) {
  const auto played = [](bool is_saturated) {
    LoopMonitor monitor(loop_bounds(limits()), kTick_s);
    for (int k = 0; k < 2000; ++k) monitor.note(1.0, is_saturated, {.displacement_in = 3.0});
    return monitor.breach().fault;
  };
  EXPECT_EQ(played(false), Fault::none);
  EXPECT_EQ(played(true), Fault::no_motion);
}

}  // namespace
}  // namespace eha::place
