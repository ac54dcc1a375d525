// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/limit_monitor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include "tests/unit/acquisition/play.hpp"

namespace eha::acquisition {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;

hal::RigReading at(double displacement_in, std::uint32_t code = 0) {
  hal::RigReading reading;
  reading.displacement_in = displacement_in;
  reading.feedback_code = code;
  return reading;
}

/// Feeds a straight motion until something trips. @returns the breach, and where the rod was
Breach move(LimitMonitor& monitor, double from_in, double speed_in_per_s, double& position_in, int ticks = 10'000) {
  Breach breach;
  for (int k = 0; k < ticks && breach.fault == Fault::none; ++k) {
    position_in = from_in + speed_in_per_s * 0.001 * k;
    breach = monitor.check(k * kTick_ns, at(position_in, static_cast<std::uint32_t>(k)), 0.0);
  }
  return breach;
}

TEST(LimitMonitor, TripsWhereTheRodCanStillStopBeforeTheEndOfItsTravel) {
  for (const double speed : {1.0, 4.0, 10.0}) {
    LimitMonitor monitor(test_limits(), 0.001);
    double position_in = 0.0;
    const Breach breach = move(monitor, 3.0, speed, position_in);
    EXPECT_EQ(breach.fault, Fault::travel_limit);
    const double braking_in = speed * speed / (2.0 * 400.0);
    EXPECT_LE(position_in + braking_in, 5.7) << "at " << speed << " in/s the rod would not stop in time";
    // Early by what the rod may have gained in speed since the middle of the estimate's window.
    const double gained_in = 400.0 * 0.011 * (0.011 / 2.0 + 0.001);
    EXPECT_GE(position_in + braking_in, 5.7 - speed * 0.013 - gained_in)
        << "at " << speed << " in/s it tripped too early";
    EXPECT_DOUBLE_EQ(breach.limit, 5.7);
  }
}

TEST(LimitMonitor, TripsInTimeOnARodThatGainsSpeedAsFastAsItBrakes) {
  const double braking = test_limits().stopping_deceleration_in_per_s2;
  for (const double run_up_in : {0.02, 0.05, 0.1, 0.2}) {
    LimitMonitor monitor(test_limits(), 0.001);
    const double start_in = 5.7 - run_up_in;
    for (int k = -100;; ++k) {
      const double time_s = std::max(0, k) * 0.001;
      const double speed = braking * time_s;
      const double position_in = start_in + 0.5 * speed * time_s;
      // A quarter of a micrometre to either side: the sensor is never quite still.
      const double noise_in = k % 2 == 0 ? 1e-5 : -1e-5;
      if (monitor.check((k + 100) * 1'000'000, at(position_in + noise_in), 0.0).fault == Fault::none) continue;
      EXPECT_LE(position_in + speed * speed / (2.0 * braking), 5.7 + 1e-5) << run_up_in << " in from the end";
      break;
    }
  }
}

TEST(LimitMonitor, GuardsTheLowerEndOfTravelInTheSameWay) {
  LimitMonitor monitor(test_limits(), 0.001);
  double position_in = 0.0;
  EXPECT_EQ(move(monitor, 3.0, -4.0, position_in).fault, Fault::travel_limit);
  EXPECT_GT(position_in, 0.2 + 4.0 * 4.0 / 800.0);
}

TEST(LimitMonitor, LetsARodThatIsOutsideMoveInwardOnlyWhereThatIsAsked) {
  // A tenth of an inch a second, from beyond each limit.
  for (const auto& [from_in, inward] : {std::pair(5.85, -0.1), std::pair(0.05, 0.1)}) {
    LimitMonitor back(test_limits(), 0.001);
    back.allow_way_back();
    double position_in = 0.0;
    EXPECT_EQ(move(back, from_in, inward, position_in, 20'000).fault, Fault::none);
    EXPECT_NEAR(position_in, from_in + inward * 19.999, 1e-9) << "2 in further, within the limits";

    LimitMonitor out(test_limits(), 0.001);
    out.allow_way_back();
    EXPECT_EQ(move(out, from_in, -inward, position_in).fault, Fault::travel_limit);
    EXPECT_LT(std::abs(position_in - from_in), 0.1);
  }
}

TEST(LimitMonitor, KeepsTheRigsLimitOnceARodHasComeBack) {
  LimitMonitor monitor(test_limits(), 0.001);
  monitor.allow_way_back();
  double position_in = 5.85;
  int k = 0;
  const auto go = [&](double speed_in_per_s, double to_in) {
    Breach breach;
    while (breach.fault == Fault::none && (to_in - position_in) * speed_in_per_s > 0.0) {
      breach = monitor.check(k * kTick_ns, at(position_in, static_cast<std::uint32_t>(k)), 0.0);
      position_in += 0.001 * speed_in_per_s;
      ++k;
    }
    return breach;
  };
  EXPECT_EQ(go(-0.1, 5.5).fault, Fault::none);
  const Breach again = go(0.1, 5.9);
  EXPECT_EQ(again.fault, Fault::travel_limit);
  EXPECT_DOUBLE_EQ(again.limit, 5.7) << "that of the rig file";
}

TEST(LimitMonitor, TripsAtOnceOnARodThatIsOutside) {
  LimitMonitor monitor(test_limits(), 0.001);
  EXPECT_EQ(monitor.check(0, at(5.71), 0.0).fault, Fault::travel_limit);
}

TEST(LimitMonitor, LetsARodMoveAwayFromANearEnd) {
  LimitMonitor monitor(test_limits(), 0.001);
  double position_in = 0.0;
  EXPECT_EQ(move(monitor, 5.69, -5.0, position_in, 500).fault, Fault::none);
}

TEST(LimitMonitor, TripsOnTheSpeedOfTheRodAndNotOnTheNoiseOfItsSensor) {
  config::RigLimits limits = test_limits();
  limits.velocity_limit_in_per_s = 2.0;
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise_in(0.0, 0.001);  // differences of neighbours alone are 1.4 in/s
  LimitMonitor still(limits, 0.001);
  for (int k = 0; k < 100'000; ++k) {
    ASSERT_EQ(still.check(k * kTick_ns, at(3.0 + noise_in(random)), 0.0).fault, Fault::none) << "seed 11, tick " << k;
  }
  LimitMonitor fast(limits, 0.001);
  double position_in = 0.0;
  const Breach breach = move(fast, 3.0, 2.1, position_in);
  EXPECT_EQ(breach.fault, Fault::velocity_limit);
  EXPECT_NEAR(breach.value, 2.1, 1e-9);
}

TEST(LimitMonitor, KeepsItsSpeedRightAcrossMissingReadings) {
  LimitMonitor monitor(test_limits(), 0.001);
  for (int k = 0; k < 200; ++k) {
    if (k % 7 == 3) continue;
    EXPECT_EQ(monitor.check(k * kTick_ns, at(3.0 + 0.004 * k, static_cast<std::uint32_t>(k)), 0.0).fault, Fault::none);
  }
  EXPECT_NEAR(monitor.velocity_in_per_s(), 4.0, 1e-9);
}

TEST(LimitMonitor, TripsOnAJumpThatNoRodCanMake) {
  LimitMonitor monitor(test_limits(), 0.001);
  for (int k = 0; k < 50; ++k) EXPECT_EQ(monitor.check(k * kTick_ns, at(3.0), 0.0).fault, Fault::none);
  EXPECT_FALSE(monitor.has_jumped());
  EXPECT_EQ(monitor.check(50 * kTick_ns, at(3.3), 0.0).fault, Fault::velocity_limit);
  EXPECT_TRUE(monitor.has_jumped());
}

TEST(LimitMonitor, TakesNoNoiseForAJumpWhereTheVelocityLimitIsLow) {
  config::RigLimits limits = test_limits();
  limits.velocity_limit_in_per_s = 0.2;  // 0.0022 in within a tick and 10 ms
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise_in(0.0, 0.0006);
  LimitMonitor monitor(limits, 0.001);
  for (int k = 0; k < 100'000; ++k) {
    ASSERT_EQ(monitor.check(k * kTick_ns, at(3.0 + noise_in(random)), 0.0).fault, Fault::none) << "tick " << k;
  }
  EXPECT_EQ(monitor.check(100'000 * kTick_ns, at(3.02), 0.0).fault, Fault::velocity_limit);
  EXPECT_TRUE(monitor.has_jumped());
}

TEST(LimitMonitor, TakesASensorForFrozenAfterItsTimeButOnlyWhileTheValveIsDriven) {
  LimitMonitor idle(test_limits(), 0.001);
  for (int k = 0; k < 1000; ++k) ASSERT_EQ(idle.check(k * kTick_ns, at(3.0, 7), 0.4).fault, Fault::none);
  LimitMonitor driven(test_limits(), 0.001);
  int k = 0;
  Breach breach;
  while (breach.fault == Fault::none && k < 1000) breach = driven.check(k++ * kTick_ns, at(3.0, 7), -2.0);
  EXPECT_EQ(breach.fault, Fault::frozen_sensor);
  EXPECT_EQ(k, 51);  // 50 ms after the first reading
}

TEST(LimitMonitor, DoesNotLookForAFrozenSensorWhenThatIsOff) {
  config::RigLimits limits = test_limits();
  limits.frozen_sensor_s = 0.0;
  LimitMonitor monitor(limits, 0.001);
  for (int k = 0; k < 5000; ++k) ASSERT_EQ(monitor.check(k * kTick_ns, at(3.0, 7), 5.0).fault, Fault::none);
}

TEST(LimitMonitor, TripsOnASensorOutsideItsValidBand) {
  config::RigLimits limits = test_limits();
  limits.sensor = config::SensorBand{.valid_min_V = -9.0, .valid_max_V = 9.5, .open_circuit_V = std::nullopt};
  LimitMonitor monitor(limits, 0.001);
  hal::RigReading reading = at(3.0);
  reading.feedback_V = 9.4;
  EXPECT_EQ(monitor.check(0, reading, 0.0).fault, Fault::none);
  reading.feedback_V = 9.6;
  Breach breach = monitor.check(kTick_ns, reading, 0.0);
  EXPECT_EQ(breach.fault, Fault::feedback_band);
  EXPECT_DOUBLE_EQ(breach.limit, 9.5);
  reading.feedback_V = -9.1;
  breach = monitor.check(2 * kTick_ns, reading, 0.0);
  EXPECT_EQ(breach.fault, Fault::feedback_band);
  EXPECT_DOUBLE_EQ(breach.value, -9.1);
}

TEST(LimitMonitor, TripsOnEmergencyStopRailAndNonsense) {
  LimitMonitor monitor(test_limits(), 0.001);
  hal::RigReading reading = at(3.0);
  reading.emergency_stop = true;
  EXPECT_EQ(monitor.check(0, reading, 0.0).fault, Fault::emergency_stop);
  reading = at(3.0);
  reading.feedback_at_rail = true;
  EXPECT_EQ(monitor.check(0, reading, 0.0).fault, Fault::feedback_rail);
  EXPECT_EQ(monitor.check(0, at(std::numeric_limits<double>::quiet_NaN()), 0.0).fault, Fault::feedback_not_finite);
  EXPECT_EQ(monitor.check(0, at(std::numeric_limits<double>::infinity()), 0.0).fault, Fault::feedback_not_finite);
}

TEST(LimitMonitor, SaysHowFarTheRodIsOnTheWayToItsLimits) {
  // At rest: the middle of the allowed travel is 2.95 in, a limit 2.75 in from it.
  const auto share_at = [](double position_in) {
    LimitMonitor monitor(test_limits(), 0.001);
    EXPECT_EQ(monitor.check(0, at(position_in), 0.0).fault, Fault::none);
    return monitor.travel_share();
  };
  EXPECT_NEAR(share_at(2.95), 0.0, 1e-12);
  EXPECT_NEAR(share_at(2.95 + 2.2), 0.8, 1e-12);
  EXPECT_NEAR(share_at(2.95 - 2.2), 0.8, 1e-12);
  // In motion: always 80 % before 100 %, and over 100 % where it trips.
  for (const double speed : {-10.0, -1.0, 1.0, 10.0}) {
    LimitMonitor monitor(test_limits(), 0.001);
    double warned_in = 2.95;
    Breach breach;
    for (int k = 0; breach.fault == Fault::none; ++k) {
      const double position_in = 2.95 + speed * 0.001 * k;
      breach = monitor.check(k * kTick_ns, at(position_in, static_cast<std::uint32_t>(k)), 0.0);
      if (monitor.travel_share() <= kWarningShare) warned_in = position_in;
      const double expected_share = k > 30 ? std::abs(speed) / 20.0 : monitor.velocity_share();
      ASSERT_NEAR(monitor.velocity_share(), expected_share, 1e-6);
    }
    EXPECT_EQ(breach.fault, Fault::travel_limit);
    EXPECT_GT(monitor.travel_share(), 1.0);
    EXPECT_LT(std::abs(warned_in - 2.95), 0.8 * 2.75 + 0.02);
  }
}

}  // namespace
}  // namespace eha::acquisition
