// SPDX-License-Identifier: GPL-3.0-or-later
// Placings, and waits for the pressure before an experiment without [start], on simulated rigs whose [following] has
// one wrong number, with a sound and with a frozen sensor; and on sound rigs, none of which may be refused or stopped.
// The real tick engine, limits, placing and simulated cylinder.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "config/measured_check.hpp"
#include "tests/unit/place/slip_rig.hpp"

namespace eha::place {
namespace {

using acquisition::Fault;
using namespace test;

/// Changes a rig's file beside [following].
using ChangeOfRig = std::function<void(config::RigConfig&, Random&)>;

/// Of which only the sample's is 8 in/s. A low limit says that the rod is slow, which a fast one need not be.
void draw_velocity_limit(config::RigConfig& rig, Random& random) {
  constexpr std::array<double, 3> kLimits_in_per_s{1.0, 2.0, 4.0};
  rig.limits.velocity_limit_in_per_s = kLimits_in_per_s.at(static_cast<std::size_t>(below(random, 3)));
}

void never_refuses_or_stops(unsigned first_seed, const ChangeOfRig& change) {
  const int runs = runs_wanted(1000);
  int measured_anew = 0;
  std::map<std::string, int> trips;
  for (int run = 0; run < runs; ++run) {
    Random random(first_seed + static_cast<unsigned>(run));
    const Source source = kSources[static_cast<std::size_t>(run) % kSources.size()];
    auto [plant, following] = drawn(source, random);
    config::RigConfig rig = rig_with(following);
    change(rig, random);
    // On a fast rod another safe voltage is no sound one.
    if (source == Source::sheet) rig.limits.safe_V = following.null_V;
    if (source != Source::sheet && is_refused(rig)) {
      // Its owner does what the refusal says.
      ++measured_anew;
      add_uncertainties(*rig.limits.following, random, true);
    }
    ASSERT_FALSE(is_refused(rig)) << "run " << run << ": " << arming_findings(rig).refusals.front();
    const double target_in = random_target(plant, random);
    const Placed result = played(plant, rig, target_in, std::nullopt, random);
    if (result.fault == Fault::none) continue;
    ++trips[std::string(to_text(result.fault))];
    ADD_FAILURE() << "run " << run << ": " << to_text(result.fault) << " at " << result.at_s << " s, to " << target_in
                  << " in from " << plant.initial_displacement_in << ", dead band " << plant.valve_dead_band_V
                  << " V, flow " << plant.valve_rated_flow_L_per_min << ", noise " << plant.sensor_noise_V
                  << " V, static friction " << plant.static_friction_N << " N";
  }
  for (const auto& [fault, count] : trips) fmt::print("false trips, {}: {}\n", fault, count);
  fmt::print("{} sound rigs, {} of them armed with a sheet only\n", runs, measured_anew);
}

TEST(SlipCampaign, NeverRefusesOrStopsASoundRig) {
  never_refuses_or_stops(1000, [](config::RigConfig&, Random&) {});
}

TEST(SlipCampaign, NeverRefusesOrStopsASoundRigOfALowVelocityLimit) {
  never_refuses_or_stops(360'000, draw_velocity_limit);
}

struct Worst {
  int runs = 0;
  int refused = 0;
  int faster = 0;  ///< than 1 in/s
  int farther = 0;
  int ends = 0;
  double fastest_in_per_s = 0.0;
  double lost_in = 0.0;

  void add(const Placed& result) {
    fastest_in_per_s = std::max(fastest_in_per_s, result.fastest_in_per_s);
    lost_in = std::max(lost_in, result.lost_in);
    if (result.fastest_in_per_s > 1.0) ++faster;
    if (result.lost_in > 0.3) ++farther;
    if (result.met_end_stop) ++ends;
  }

  void print(const std::string& kind) const {
    fmt::print(
        "{:55} {:4} runs, {:4} refused, {:3} over 1 in/s, {:3} over 0.3 in, {} at an end; at most {:.2f} in/s, {:.2f} "
        "in lost\n",
        kind, runs, refused, faster, farther, ends, fastest_in_per_s, lost_in);
  }
};

void expect_slow(const Placed& result, const std::string& what) {
  EXPECT_LE(result.fastest_in_per_s, 1.0) << what;
  EXPECT_LE(result.lost_in, 0.3) << what;
  EXPECT_FALSE(result.met_end_stop) << what;
}

/// Drives rods whose file has a slip, with a sensor that is sound, dead from the start, or freezes.
/// @param first_seed  of the first run   @param slip_of  changes the file of a drawn rig
/// @param change  of the rig's file beside [following]
void keeps_slow(
    unsigned first_seed, const std::function<Slip(Drawn&, Random&)>& slip_of,
    const ChangeOfRig& change = [](config::RigConfig&, Random&) {}) {
  const int runs = runs_wanted(1000);
  std::map<std::string, Worst> worst;
  for (int run = 0; run < runs; ++run) {
    Random random(first_seed + static_cast<unsigned>(run));
    const std::size_t source = static_cast<std::size_t>(run) % kSources.size();
    Drawn of_run = drawn(kSources[source], random);
    const Slip slip = slip_of(of_run, random);
    const hal::SimOptions& plant = of_run.plant;
    config::RigConfig rig = rig_with(of_run.following);
    change(rig, random);
    const auto tick_ms = static_cast<int>(std::lround(rig.realtime.sample_period_s / kTick_s));
    const double target_in = random_target(plant, random, tick_ms > 1 ? kFromEndAtALongTick_in : kFromEnd_in);
    std::optional<hal::InjectedFault> fault;
    if (below(random, 2) == 0) {
      fault = {.kind = hal::FaultKind::stuck_sensor,
               .first_tick = below(random, 2) == 0 ? 0 : (200 + below(random, 3000)) / tick_ms,
               .ticks = hal::InjectedFault::kAlways,
               .amount = 0.0,
               .noise_LSB = uniform(random, 0.0, 30.0)};
    }
    const std::string kind = fmt::format("{:21} {:9} {}", slip.key, kSourceNames[source],
                                         !fault                   ? "sound"
                                         : fault->first_tick == 0 ? "frozen from the start"
                                                                  : "freezes");
    Worst& of_kind = worst[kind];
    ++of_kind.runs;
    if (is_refused(rig)) {
      ++of_kind.refused;
      continue;
    }
    const Placed result = played(plant, rig, target_in, fault, random);
    const std::string what = fmt::format(
        "run {}, tick {} ms: {} {:.10g} for {:.10g}, {}, {} at {:.2f} s, null {:.2f} V, dead band {:.2f} V, delay "
        "{:.2f} s, flow {:.1f}: {:.2f} in/s, {:.2f} in lost",
        run, tick_ms, kind, slip.after, slip.before, fault ? fault->noise_LSB : -1.0, to_text(result.fault),
        result.at_s, -plant.valve_null_offset_V, plant.valve_dead_band_V, rig.limits.following->pressure_delay_s,
        plant.valve_rated_flow_L_per_min, result.fastest_in_per_s, result.lost_in);
    of_kind.add(result);
    expect_slow(result, what);
  }
  Worst all;
  for (const auto& [kind, of_kind] : worst) {
    of_kind.print(kind);
    all.refused += of_kind.refused;
    all.fastest_in_per_s = std::max(all.fastest_in_per_s, of_kind.fastest_in_per_s);
    all.lost_in = std::max(all.lost_in, of_kind.lost_in);
  }
  fmt::print("{} slips, {} refused; at most {:.2f} in/s, {:.2f} in lost\n", runs, all.refused, all.fastest_in_per_s,
             all.lost_in);
}

TEST(SlipCampaign, KeepsASlipOfThePenSlow) {
  keeps_slow(40'000, [](Drawn& rig, Random& random) { return random_slip(rig.following, random); });
}

/// Of a null up to 0.6 V from 0 V.
TEST(SlipCampaign, KeepsAWrongSignOfTheNullSlow) {
  keeps_slow(120'000, [](Drawn& rig, Random& random) {
    const double further_V = std::copysign(uniform(random, 0.0, 0.3), -rig.plant.valve_null_offset_V);
    rig.plant.valve_null_offset_V -= further_V;
    config::Following& following = rig.following;
    following.null_V += further_V;
    if (following.measured_check) following.measured_check = config::measured_check_of(following);
    const double before_V = following.null_V;
    following.null_V = -following.null_V;
    return Slip{.key = "sign of null", .before = before_V, .after = following.null_V};
  });
}

/// Both gains, one as the other: no ratio of them shows it.
Slip gains_in_another_unit(Drawn& rig, Random& random) {
  const double factor = below(random, 2) == 0 ? 25.4 : 10.0;
  config::Following& following = rig.following;
  const double before = following.gain_positive_in_per_V_s;
  following.gain_positive_in_per_V_s /= factor;
  following.gain_negative_in_per_V_s /= factor;
  return {.key = fmt::format("gains / {}", factor), .before = before, .after = following.gain_positive_in_per_V_s};
}

TEST(SlipCampaign, KeepsGainsInAnotherUnitSlow) { keeps_slow(200'000, gains_in_another_unit); }

/// The growth of the volts suits the velocity limit.
TEST(SlipCampaign, KeepsASlipOfThePenSlowAtALowVelocityLimit) {
  keeps_slow(
      400'000,
      [](Drawn& rig, Random& random) {
        return below(random, 2) == 0 ? gains_in_another_unit(rig, random) : random_slip(rig.following, random);
      },
      draw_velocity_limit);
}

/// Of 10 to 50 ms, the longest that is armed.
void draw_long_tick(config::RigConfig& rig, Random& random) {
  rig.realtime.sample_period_s = 10 * kTick_s * (1 + below(random, 5));
}

TEST(SlipCampaign, KeepsASlipOfThePenSlowAtALongTick) {
  keeps_slow(
      340'000, [](Drawn& rig, Random& random) { return random_slip(rig.following, random); }, draw_long_tick);
}

/// Sound files: no check acts sooner than a tick after its reading.
TEST(SlipCampaign, KeepsASensorThatFreezesAtALongTickSlow) {
  const int runs = runs_wanted(1000);
  std::map<int, Worst> worst;
  for (int run = 0; run < runs; ++run) {
    Random random(300'000 + static_cast<unsigned>(run));
    Drawn of_run = drawn(kSources[static_cast<std::size_t>(run) % kSources.size()], random);
    config::RigConfig rig = rig_with(of_run.following);
    draw_long_tick(rig, random);
    const auto tick_ms = static_cast<int>(std::lround(rig.realtime.sample_period_s / kTick_s));
    const double target_in = random_target(of_run.plant, random, kFromEndAtALongTick_in);
    const bool is_frozen = run % 4 != 0;
    const hal::InjectedFault fault{.kind = hal::FaultKind::stuck_sensor,
                                   .first_tick = below(random, 2) == 0 ? 0 : (200 + below(random, 3000)) / tick_ms,
                                   .ticks = hal::InjectedFault::kAlways,
                                   .noise_LSB = uniform(random, 0.0, 30.0)};
    Worst& of_tick = worst[tick_ms];
    ++of_tick.runs;
    if (is_refused(rig)) {
      ++of_tick.refused;
      continue;
    }
    const Placed result = played(of_run.plant, rig, target_in, is_frozen ? std::optional(fault) : std::nullopt, random);
    const std::string what = fmt::format(
        "run {}: tick {} ms, {} at {:.2f} s, dead band {:.2f} V, flow {:.1f}: {:.2f} in/s, {:.2f} in "
        "lost",
        run, tick_ms, to_text(result.fault), result.at_s, of_run.plant.valve_dead_band_V,
        of_run.plant.valve_rated_flow_L_per_min, result.fastest_in_per_s, result.lost_in);
    of_tick.add(result);
    if (!is_frozen) {
      EXPECT_EQ(result.fault, Fault::none) << what;
    }
    expect_slow(result, what);
  }
  for (const auto& [tick_ms, of_tick] : worst) of_tick.print(fmt::format("tick of {} ms", tick_ms));
}

/// Long placings in which the sensor fails.
/// @param failure_of  the failure, which begins at a tick of its own
/// @param from, to  the rods' gains [in/(V s)]
void finds_on_a_long_way(unsigned first_seed, const std::function<hal::InjectedFault(Random&)>& failure_of, double from,
                         double to, double most_s, double most_way_in) {
  const int runs = runs_wanted(1000);
  int played = 0;
  std::map<std::string, int> ends;
  double longest_s = 0.0;
  double furthest_in = 0.0;
  for (int run = 0; run < runs; ++run) {
    Random random(first_seed + static_cast<unsigned>(run));
    const Source source = kSources[static_cast<std::size_t>(run) % kSources.size()];
    auto [plant, following] = drawn(source, random);
    const bool is_up = below(random, 2) == 0;
    plant.initial_displacement_in = is_up ? 1.0 : 4.9;
    config::RigConfig rig = rig_with(following);
    if (source == Source::sheet) rig.limits.safe_V = following.null_V;
    const double gain = 2.0 * std::max(following.gain_positive_in_per_V_s, following.gain_negative_in_per_V_s);
    if (is_refused(rig) || gain < from || gain > to) continue;
    ++played;
    const double failed_s = following.pressure_delay_s + uniform(random, 1.5, 5.0);
    hal::InjectedFault failure = failure_of(random);
    failure.first_tick = static_cast<std::int64_t>(std::llround(failed_s / kTick_s));
    failure.ticks = hal::InjectedFault::kAlways;
    const Placed result = placed(plant, rig, is_up ? 4.7 : 1.2, failure);
    ++ends[result.fault == Fault::none ? "not found" : std::string(to_text(result.fault))];
    const std::string what = fmt::format(
        "run {}: {}, {:.2f} s and {:.2f} in after it failed at {:.2f} s, slope or share {:.2f}, each {:.3f} V, dead "
        "band {:.2f} V, flow {:.1f}",
        run, to_text(result.fault), result.at_s - failed_s, result.lost_in, failed_s, failure.amount, failure.way_V,
        plant.valve_dead_band_V, plant.valve_rated_flow_L_per_min);
    EXPECT_NE(result.fault, Fault::none) << what;
    EXPECT_LE(result.at_s - failed_s, most_s) << what;
    EXPECT_LE(result.lost_in, most_way_in) << what;
    EXPECT_FALSE(result.met_end_stop) << what;
    longest_s = std::max(longest_s, result.at_s - failed_s);
    furthest_in = std::max(furthest_in, result.lost_in);
  }
  for (const auto& [fault, count] : ends) fmt::print("{}: {}\n", fault, count);
  EXPECT_GT(played, 0);
  fmt::print("{} long ways: found after {:.2f} s and {:.2f} in at most\n", played, longest_s, furthest_in);
}

hal::InjectedFault slope_of(double share) { return {.kind = hal::FaultKind::scaled_sensor, .amount = share}; }

/// On a fast rod the valve's errors hide more of the speed that lacks.
constexpr double kFast_in_per_V_s = 1.4;

/// Half of the sensor's slope from a moment on: a cable of two in parallel, a supply that breaks down.
TEST(SlipCampaign, FindsASlopeThatHalvesOnALongWay) {
  finds_on_a_long_way(
      80'000, [](Random&) { return slope_of(0.5); }, 0.0, kFast_in_per_V_s, 1.5, 0.5);
}

TEST(SlipCampaign, FindsASlopeThatHalvesOnALongWayOfAFastRod) {
  finds_on_a_long_way(
      80'000, [](Random&) { return slope_of(0.5); }, kFast_in_per_V_s, 3.0, 1.5, 0.55);
}

TEST(SlipCampaign, FindsASlopeThatFallsTo06OnALongWay) {
  finds_on_a_long_way(
      82'000, [](Random&) { return slope_of(0.6); }, 0.0, kFast_in_per_V_s, 3.0, 1.0);
}

/// A wire that holds in between: no moment of half a second need look wrong. The sample's sensor gives 3.4 V an inch.
TEST(SlipCampaign, FindsAWireThatSlipsInJerksOnALongWay) {
  finds_on_a_long_way(
      84'000,
      [](Random& random) {
        return hal::InjectedFault{.kind = hal::FaultKind::slipping_sensor,
                                  .amount = uniform(random, 0.5, 0.7),
                                  .way_V = uniform(random, 0.05, 0.9)};
      },
      0.0, kFast_in_per_V_s, 1.5, 0.5);
}

}  // namespace
}  // namespace eha::place
