// SPDX-License-Identifier: GPL-3.0-or-later
// Characterisations of rigs without [following] whose sensor is dead from the start or dies on the way: how far and how
// fast the rod goes before the hydraulics are off.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <random>
#include <string>

#include "tests/unit/place/unknown_rig.hpp"

namespace eha::place {
namespace {

/// The worst of many runs.
struct Campaign {
  int runs = 0;
  int hits = 0;  ///< of an end stop, at over 0.1 in/s
  double fastest_in_per_s = 0.0;
  double way_in = 0.0;
  double impact_in_per_s = 0.0;
  std::map<std::string, int> ends = {};

  void add(const Measured& result) {
    ++runs;
    hits += result.impact_in_per_s > 0.1 ? 1 : 0;
    fastest_in_per_s = std::max(fastest_in_per_s, result.fastest_in_per_s);
    way_in = std::max(way_in, result.way_in);
    impact_in_per_s = std::max(impact_in_per_s, result.impact_in_per_s);
    ++ends[result.is_complete ? "completed" : std::string(acquisition::to_text(result.fault))];
  }

  void print(const char* name) const {
    for (const auto& [end, count] : ends) fmt::print("{}: {}\n", end, count);
    fmt::print("{}: {} runs, {:.2f} in and {:.2f} in/s at most, {} end stops at over 0.1 in/s, {:.3f} in/s at most\n",
               name, runs, way_in, fastest_in_per_s, hits, impact_in_per_s);
  }
};

/// A sensor that is right until it fails. A valve that is open at the safe voltage moves the rod before anything is
/// measured, and is left out.
Drawn right(unsigned run) {
  Drawn rig = drawn(run);
  rig.factor = 1.0;
  const double closed_V = std::abs(rig.plant.valve_null_offset_V) + 0.02;
  rig.plant.valve_dead_band_V = std::max(rig.plant.valve_dead_band_V, closed_V);
  return rig;
}

std::string named(unsigned run, const Drawn& of_run, const Measured& result) {
  return fmt::format(
      "run {}: gain {:.2f} in/(V s), null {:+.2f} V, dead band {:.2f} V, noise {:.4f} V, from {:.2f} in: {} after "
      "{:.1f} s, {:.2f} in, {:.2f} in/s, impact {:.3f} in/s",
      run, of_run.gain_in_per_V_s, -of_run.plant.valve_null_offset_V, of_run.plant.valve_dead_band_V,
      of_run.plant.sensor_noise_V, of_run.plant.initial_displacement_in, acquisition::to_text(result.fault),
      result.at_s, result.way_in, result.fastest_in_per_s, result.impact_in_per_s);
}

config::RigConfig of_the_sample(std::mt19937_64&) { return unknown_rig(); }

/// Slew limits from the least that is armed, and a range of +-5 or +-10 V.
config::RigConfig with_drawn_limits(std::mt19937_64& random) {
  config::RigConfig rig = unknown_rig();
  config::RigLimits& limits = rig.limits;
  const double half_V = std::bernoulli_distribution(0.5)(random) ? 5.0 : 10.0;
  limits.command_min_V = -half_V;
  limits.command_max_V = half_V;
  limits.slew_V_per_s = 0.5 * half_V * std::exp(std::uniform_real_distribution<double>(0.0, std::log(16.0))(random));
  return rig;
}

/// What else happens to a run's rig: nothing.
void left_alone(Drawn&, std::mt19937_64&) {}

/// Runs a campaign; each run's rig and failure are drawn.
template <class RigOf, class AtTick, class Change>
Campaign played(int runs, RigOf rig_of, AtTick at_tick, Change change) {
  const auto first = static_cast<unsigned>(number_of("EHA_CAMPAIGN_FIRST", 0));
  const bool says_each = std::getenv("EHA_CAMPAIGN_SAYS") != nullptr;
  Campaign campaign;
  for (unsigned run = first; run < first + static_cast<unsigned>(runs); ++run) {
    std::mt19937_64 random(90'000 + run);
    Drawn of_run = right(run);
    const config::RigConfig rig = rig_of(random);
    const hal::InjectedFault fault{.kind = hal::FaultKind::stuck_sensor,
                                   .first_tick = at_tick(random),
                                   .ticks = hal::InjectedFault::kAlways,
                                   .noise_LSB = std::uniform_real_distribution<double>(1.0, 10.0)(random)};
    change(of_run, random);
    const Measured result = measured(of_run, rig, fault);
    campaign.add(result);
    if (says_each)
      fmt::print("{} (failed at {:.1f} s)\n", named(run, of_run, result), 1e-3 * static_cast<double>(fault.first_tick));
  }
  return campaign;
}

TEST(DeadSensorCampaign, MovesTheRodLittleWhereTheSensorIsDeadFromTheStart) {
  const int runs = number_of("EHA_CAMPAIGN_RUNS", 300);
  const auto at_once = [](auto&) { return std::int64_t{1}; };
  const Campaign campaign = played(runs, of_the_sample, at_once, left_alone);
  campaign.print("dead from the start");
  EXPECT_EQ(campaign.hits, 0);
  EXPECT_LE(campaign.way_in, 0.8);
}

TEST(DeadSensorCampaign, MovesTheRodNoFartherWithAnotherSlewLimitOrRange) {
  const int runs = number_of("EHA_CAMPAIGN_RUNS", 300);
  const auto at_once = [](auto&) { return std::int64_t{1}; };
  const Campaign campaign = played(runs, with_drawn_limits, at_once, left_alone);
  campaign.print("dead from the start, other limits");
  EXPECT_EQ(campaign.hits, 0);
  EXPECT_LE(campaign.way_in, 0.8);
}

double drawn_between(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// A dead sensor whose reading does something beside: hops once or again and again, settles after the pump's start, or
/// wanders.
void disturb(Drawn& rig, std::mt19937_64& random) {
  const double sign = std::bernoulli_distribution(0.5)(random) ? 1.0 : -1.0;
  const double size_in = sign * std::exp(drawn_between(random, std::log(0.007), std::log(0.08)));
  const double at_s =
      std::bernoulli_distribution(0.5)(random) ? drawn_between(random, 0.4, 1.0) : drawn_between(random, 1.0, 15.0);
  const double period_s = std::exp(drawn_between(random, std::log(0.3), std::log(10.0)));
  const double high_s = std::min(0.5 * period_s, drawn_between(random, 0.1, 2.0));
  switch (std::uniform_int_distribution<int>(0, 3)(random)) {
    case 0:
      rig.disturbance = [=](double time_s) { return time_s > at_s ? size_in : 0.0; };
      break;
    case 1:
      rig.disturbance = [=](double time_s) { return std::fmod(time_s, period_s) > high_s ? size_in : 0.0; };
      break;
    case 2:
      rig.disturbance = [=](double time_s) { return size_in * std::expm1(-time_s / (0.2 * period_s)); };
      break;
    default:
      rig.disturbance = [=](double time_s) {
        return 0.3 * size_in * std::sin(2.0 * std::numbers::pi * time_s / period_s);
      };
  }
}

TEST(DeadSensorCampaign, MovesTheRodLittleWhereTheReadingOfADeadSensorChangesByItself) {
  const int runs = number_of("EHA_CAMPAIGN_RUNS", 300);
  const auto at_once = [](auto&) { return std::int64_t{1}; };
  const Campaign campaign = played(runs, of_the_sample, at_once, disturb);
  campaign.print("dead from the start, disturbed");
  EXPECT_EQ(campaign.hits, 0);
  EXPECT_LE(campaign.way_in, 0.8);
}

void delay_pressure(Drawn& rig, std::mt19937_64& random) { rig.pressure_delay_s = drawn_between(random, 0.5, 15.0); }

TEST(DeadSensorCampaign, KeepsTheRodSlowWhereThePressureIsLateAndTheSensorFreezes) {
  const int runs = number_of("EHA_CAMPAIGN_RUNS", 300);
  const auto soon = [](std::mt19937_64& random) {
    return std::uniform_int_distribution<std::int64_t>(500, 30'000)(random);
  };
  const Campaign campaign = played(runs, of_the_sample, soon, delay_pressure);
  campaign.print("late pressure, freezing soon");
  EXPECT_LE(campaign.hits, campaign.runs / 100);
  EXPECT_LE(campaign.way_in, 1.0);
}

/// Sound rods, from the least slew limit that is armed on.
TEST(UnknownValveCampaign, IsMeasuredAtLowSlewLimits) {
  const int runs = number_of("EHA_CAMPAIGN_RUNS", 40);
  const auto first = static_cast<unsigned>(number_of("EHA_CAMPAIGN_FIRST", 0));
  const bool says_each = std::getenv("EHA_CAMPAIGN_SAYS") != nullptr;
  for (const double slew_V_per_s : {2.5, 5.0, 20.0}) {
    config::RigConfig rig = unknown_rig();
    rig.limits.slew_V_per_s = slew_V_per_s;
    Campaign campaign;
    for (unsigned run = first; run < first + static_cast<unsigned>(runs); ++run) {
      const Drawn of_run = right(run);
      const Measured result = measured(of_run, rig);
      campaign.add(result);
      if (says_each) fmt::print("{} V/s, {}\n", slew_V_per_s, named(run, of_run, result));
    }
    campaign.print(fmt::format("sound, {} V/s", slew_V_per_s).c_str());
    EXPECT_EQ(campaign.hits, 0);
    EXPECT_GE(campaign.ends["completed"], campaign.runs * 19 / 20) << slew_V_per_s;
  }
}

std::int64_t on_the_way(std::mt19937_64& random) {
  return std::uniform_int_distribution<std::int64_t>(1, 420'000)(random);
}

TEST(DeadSensorCampaign, KeepsTheRodSlowWhereTheSensorFreezesOnTheWay) {
  const Campaign campaign = played(number_of("EHA_CAMPAIGN_RUNS", 300), of_the_sample, on_the_way, left_alone);
  campaign.print("freezing on the way");
  EXPECT_LE(campaign.hits, campaign.runs / 100);
  EXPECT_LE(campaign.way_in, 1.0);
}

TEST(DeadSensorCampaign, KeepsTheRodSlowWithAnotherSlewLimitOrRange) {
  const Campaign campaign = played(number_of("EHA_CAMPAIGN_RUNS", 300), with_drawn_limits, on_the_way, left_alone);
  campaign.print("freezing on the way, other limits");
  EXPECT_LE(campaign.hits, campaign.runs / 100);
  EXPECT_LE(campaign.way_in, 1.0);
}

}  // namespace
}  // namespace eha::place
