// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/slip_monitor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace eha::acquisition {
namespace {

constexpr double kTick_s = 0.001;
constexpr double kLimit_in_per_s = 8.0;

/// What 60 s of readings lead to.
struct Seen {
  Breach breach;
  double at_s = 0.0;  ///< of the breach
  double slipped_in = 0.0;
};

/// A rod swings by 1.5 in at up to 3.8 in/s.
double rod_in(double t_s) { return 3.0 + 1.5 * std::sin(2.5 * t_s); }

/// @param error_in  of the sensor at a time
Seen watched(double noise_in, const std::function<double(double)>& error_in, double earlier_in = 0.0,
             double tick_s = kTick_s) {
  SlipMonitor monitor(kLimit_in_per_s, earlier_in);
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  Seen seen;
  for (int k = 0; k * tick_s < 60.0 && seen.breach.fault == Fault::none; ++k) {
    seen.at_s = k * tick_s;
    const double speed = (rod_in(seen.at_s - tick_s) - rod_in(seen.at_s - 0.02 - tick_s)) / 0.02;
    seen.breach =
        monitor.check(rod_in(seen.at_s) + error_in(seen.at_s) + noise_in * normal(random), speed, tick_s, tick_s);
  }
  seen.slipped_in = monitor.slipped_in();
  return seen;
}

TEST(SlipMonitor, EndsOnACouplingThatSlipsOnceByMoreThanItAllows) {
  for (const double by_in : {0.06, 0.09, -0.06, -0.09}) {
    const Seen seen = watched(0.0003, [&](double t_s) { return t_s > 5.0 ? by_in : 0.0; });
    EXPECT_EQ(seen.breach.fault, Fault::sensor_slip) << by_in;
    EXPECT_NEAR(seen.at_s, 5.01, 0.003) << by_in;
    EXPECT_NEAR(seen.breach.value, by_in, 0.004);
  }
}

TEST(SlipMonitor, EndsOnASlipInTheFirstReadings) {
  for (const double by_in : {0.08, -0.12}) {
    const Seen seen = watched(0.0003, [&](double t_s) { return t_s > 0.0025 ? by_in : 0.0; });
    EXPECT_EQ(seen.breach.fault, Fault::sensor_slip) << by_in;
    EXPECT_NEAR(seen.at_s, 0.013, 0.003) << by_in;
  }
}

TEST(SlipMonitor, CountsAStepBeforeItHasLasted) {
  SlipMonitor monitor(kLimit_in_per_s, 0.0);
  for (int k = 0; k < 100; ++k) static_cast<void>(monitor.check(3.0 + 0.0002 * (k % 2), 0.0, kTick_s, kTick_s));
  EXPECT_EQ(monitor.slipped_in(), 0.0);
  EXPECT_EQ(monitor.check(3.06, 0.0, kTick_s, kTick_s).fault, Fault::none);
  EXPECT_NEAR(monitor.slipped_in(), 0.06, 0.001) << "what ends the run now must not forget it";
}

TEST(SlipMonitor, SumsSmallerSlipsAndThoseOfTheRunsBefore) {
  const auto slips = [](double t_s) { return 0.03 * std::floor(t_s / 10.0); };
  EXPECT_NEAR(watched(0.0003, slips).at_s, 20.01, 0.003);
  EXPECT_NEAR(watched(0.0003, slips, 0.03).at_s, 10.01, 0.003);
  const Seen once = watched(0.0003, [](double t_s) { return t_s > 5.0 ? 0.03 : 0.0; });
  EXPECT_EQ(once.breach.fault, Fault::none);
  EXPECT_NEAR(once.slipped_in, 0.03, 0.004);
}

TEST(SlipMonitor, CountsNoInterferenceThatComesBack) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  int left = 0;
  double height_in = 0.0;
  const auto bursts = [&](double) {
    if (left == 0 && uniform(random) < 0.01) {
      left = 1 + static_cast<int>(4.0 * uniform(random));
      height_in = uniform(random) < 0.5 ? -0.08 : 0.08;
    }
    return left > 0 ? (--left, height_in) : 0.0;
  };
  for (const double noise_in : {0.0, 0.0003, 0.0015}) {
    const Seen seen = watched(noise_in, bursts);
    EXPECT_EQ(seen.breach.fault, Fault::none) << noise_in << ": " << seen.slipped_in;
  }
}

TEST(SlipMonitor, CountsNothingOfASoundSensor) {
  const double hum_in = 0.03;
  for (const double tick_s : {0.0002, 0.001, 0.005, 0.02}) {
    for (const double noise_in : {0.0, 0.0003, 0.0015, 0.005}) {
      EXPECT_EQ(watched(
                    noise_in, [](double) { return 0.0; }, 0.0, tick_s)
                    .slipped_in,
                0.0)
          << tick_s << ", " << noise_in;
    }
    const auto hum = [&](double t_s) { return hum_in * std::sin(314.159 * t_s); };
    EXPECT_EQ(watched(0.0003, hum, 0.0, tick_s).slipped_in, 0.0) << tick_s;
  }
  // A converter of 0.005 in a code.
  const auto coarse = [](double t_s) { return 0.005 * std::round(rod_in(t_s) / 0.005) - rod_in(t_s); };
  EXPECT_EQ(watched(0.0, coarse).slipped_in, 0.0);
}

TEST(SlipMonitor, TakesAReadingThatAThreadGotLateForNoJump) {
  SlipMonitor monitor(kLimit_in_per_s, 0.0);
  for (int k = 0; k < 1000; ++k) {
    // Each 100 ticks the thread waits 50 ms between its wake-up and its call.
    const double late_s = k % 100 == 99 ? 0.05 : 0.0;
    const double since_s = k % 100 == 0 && k > 0 ? 0.051 : 0.001;
    const double t_s = 0.001 * k + 0.05 * (k / 100) + late_s;
    (void)monitor.check(7.0 * t_s, 7.0, since_s, std::max(since_s, 0.001 + late_s));
  }
  EXPECT_EQ(monitor.slipped_in(), 0.0);
}

}  // namespace
}  // namespace eha::acquisition
