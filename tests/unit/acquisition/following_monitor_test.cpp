// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/following_monitor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "daemon/acquisition/run_report.hpp"
#include "tests/unit/acquisition/play.hpp"

namespace eha::acquisition {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;

/// A valve of 0.4 in/(V s), half of it each way, null at -0.2 V, dead band 0.3 V.
config::RigLimits commissioned_limits() {
  config::RigLimits limits = test_limits();
  limits.following = config::Following{.gain_positive_in_per_V_s = 0.2,
                                       .gain_negative_in_per_V_s = 0.2,
                                       .null_V = -0.2,
                                       .dead_band_V = 0.3,
                                       .limit_in = 0.1,
                                       .pressure_delay_s = 0.0};
  return limits;
}

/// Feeds a held voltage and places in time until something trips. @returns the breach; `ticks` is how long it took
Breach hold(FollowingMonitor& monitor, double applied_V, const std::function<double(double)>& place_in, int& ticks) {
  Breach breach;
  for (ticks = 0; ticks < 20'000 && breach.fault == Fault::none; ++ticks) {
    breach = monitor.check(ticks * kTick_ns, place_in(ticks * 0.001), applied_V);
  }
  return breach;
}

TEST(FollowingMonitor, TripsOnASensorThatStandsStillWhateverItsNoise) {
  for (const double noise_in : {0.0, 0.0001, 0.003}) {
    std::mt19937_64 random(3);
    std::normal_distribution<double> noise(0.0, 1.0);
    FollowingMonitor monitor(following_rule(commissioned_limits()));
    monitor.begin(0);
    int ticks = 0;
    const Breach breach = hold(
        monitor, 1.8, [&](double) { return 3.0 + noise_in * noise(random); }, ticks);
    EXPECT_EQ(breach.fault, Fault::not_following);
    EXPECT_GT(breach.value, 0.1);
    EXPECT_DOUBLE_EQ(breach.limit, 0.1);
    // 0.2 in/(V s) times 1.7 V outside the dead band take 0.294 s for 0.1 in.
    EXPECT_NEAR(ticks * 0.001, 0.294, 0.02) << "seed 3, noise " << noise_in << " in";
  }
}

TEST(FollowingMonitor, TripsOnASensorThatMovesTheWrongWay) {
  FollowingMonitor monitor(following_rule(commissioned_limits()));
  monitor.begin(0);
  int ticks = 0;
  const Breach breach = hold(
      monitor, 0.0, [](double t) { return 3.0 - 0.3 * t; }, ticks);
  EXPECT_EQ(breach.fault, Fault::unexplained_motion) << "inside the dead band nothing must move, and nothing may";
  EXPECT_LT(ticks, 600);
}

TEST(FollowingMonitor, LetsARodFollow) {
  for (const double command_V : {1.8, 4.0, -1.8}) {
    FollowingMonitor monitor(following_rule(commissioned_limits()));
    monitor.begin(0);
    int ticks = 0;
    const double speed = 0.4 * (command_V + 0.2 - std::copysign(0.3, command_V));
    EXPECT_EQ(hold(
                  monitor, command_V, [&](double t) { return 3.0 + speed * t; }, ticks)
                  .fault,
              Fault::none);
  }
}

TEST(FollowingMonitor, DoesNotAskForMotionInsideTheDeadBand) {
  for (const double command_V : {0.09, -0.49}) {
    FollowingMonitor monitor(following_rule(commissioned_limits()));
    monitor.begin(0);
    int ticks = 0;
    EXPECT_EQ(hold(
                  monitor, command_V, [](double) { return 3.0; }, ticks)
                  .fault,
              Fault::none);
  }
}

TEST(FollowingMonitor, WaitsForThePressureAndForTheHydraulics) {
  config::RigLimits limits = commissioned_limits();
  FollowingMonitor off(following_rule(limits));
  int ticks = 0;
  EXPECT_EQ(hold(
                off, 4.0, [](double) { return 3.0; }, ticks)
                .fault,
            Fault::none);
  limits.following->pressure_delay_s = 2.0;
  FollowingMonitor on(following_rule(limits));
  on.begin(0);
  EXPECT_EQ(hold(
                on, 1.8, [](double) { return 3.0; }, ticks)
                .fault,
            Fault::not_following);
  EXPECT_NEAR(ticks * 0.001, 2.294, 0.02);
}

/// The command stands at the null of the file. 0.4 in/(V s), wrong by 0.42 V beyond the dead band: 0.17 in/s; a valve
/// of 2.4 in/(V s) whose dead band is 0.1 V, wrong by 0.19 V: 0.21 in/s.
TEST(FollowingMonitor, FindsAWrongNullWhileThePressureBuildsUp) {
  config::RigLimits limits = commissioned_limits();
  limits.following->pressure_delay_s = 3.0;
  const auto waiting = [&](double in_per_s, int& ticks) {
    FollowingMonitor monitor(following_rule(limits));
    monitor.begin(0);
    return hold(
               monitor, -0.2, [&](double t) { return 3.0 + in_per_s * std::min(t, 3.0); }, ticks)
        .fault;
  };
  int ticks = 0;
  EXPECT_EQ(waiting(-0.17, ticks), Fault::unexplained_motion);
  EXPECT_LT(ticks, 1100);
  limits.following->gain_positive_in_per_V_s = 1.2;
  limits.following->gain_negative_in_per_V_s = 1.2;
  EXPECT_EQ(waiting(0.21, ticks), Fault::unexplained_motion) << "0.2 V of the null would explain 0.48 in/s";
  EXPECT_LT(ticks, 1100);
  EXPECT_EQ(waiting(-0.05, ticks), Fault::none) << "a rod that sags";
  EXPECT_EQ(waiting(0.09, ticks), Fault::none) << "a null that is known to 0.04 V";
  limits.following->null_uncertainty_V = 0.12;
  EXPECT_EQ(waiting(0.25, ticks), Fault::none) << "a null that is known to 0.12 V";
}

TEST(FollowingMonitor, LeavesNoMoreThanItsLimitOfARodThatCreepsBack) {
  FollowingMonitor monitor(following_rule(test_limits()));
  monitor.begin(0);
  std::int64_t tick = 0;
  double rod_in = 3.0;
  const auto play = [&](double command_V, double speed_in_per_s, double seconds) {
    for (const std::int64_t end = tick + std::llround(seconds * 1000.0); tick < end; ++tick) {
      EXPECT_EQ(monitor.check(tick * kTick_ns, rod_in, command_V).fault, Fault::none) << tick;
      rod_in += speed_in_per_s * 0.001;
    }
  };
  for (int pulse = 0; pulse < 10; ++pulse) {
    play(2.0, 0.2, 1.0);
    play(0.0, -0.03, 1.0);  // a leak, or a null that is not at 0 V
  }
  EXPECT_LE(monitor.left_in()[0], monitor.peak_missing() * following_rule(test_limits()).missing_limit_in);
}

TEST(FollowingMonitor, MeasuresTheSameWhenReadingsAreMissing) {
  FollowingMonitor monitor(following_rule(commissioned_limits()));
  monitor.begin(0);
  Breach breach;
  int k = 0;
  for (; k < 2000 && breach.fault == Fault::none; ++k) {
    if (k % 3 == 1) continue;
    breach = monitor.check(k * kTick_ns, 3.0, 1.8);
  }
  EXPECT_EQ(breach.fault, Fault::not_following);
  EXPECT_NEAR(k * 0.001, 0.294, 0.02);
}

TEST(FollowingMonitor, NamesTheLikelyCausesInTheirOrder) {
  RunReport report;
  report.outcome = Outcome::faulted;
  report.fault.fault = Fault::not_following;
  report.fault.value = 0.12;
  report.fault.limit = 0.1;
  const std::string text = describe(report);
  const std::size_t hydraulics = text.find("hydraulics off");
  const std::size_t valve = text.find("valve unplugged");
  const std::size_t sensor = text.find("sensor");
  EXPECT_LT(hydraulics, valve) << text;
  EXPECT_LT(valve, sensor) << text;
  EXPECT_NE(text.find("the rod moved 0.120 in less than"), std::string::npos) << text;
  EXPECT_LT(sensor, text.find("out of date")) << text;
  EXPECT_EQ(text.find("eha characterise"), std::string::npos) << "which may be what has ended so: " << text;
}

TEST(FollowingMonitor, FallsBackToARuleFromTheLimits) {
  const FollowingRule rule = following_rule(test_limits());
  EXPECT_DOUBLE_EQ(rule.least_gain_in_per_V_s[0], 20.0 / 5.0 / 32.0);
  EXPECT_DOUBLE_EQ(rule.greatest_gain_in_per_V_s[1], 20.0 / 5.0);
  EXPECT_DOUBLE_EQ(rule.dead_band_V, 0.75);
  EXPECT_DOUBLE_EQ(rule.missing_limit_in, 0.02);
}

}  // namespace
}  // namespace eha::acquisition
