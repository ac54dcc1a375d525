// SPDX-License-Identifier: GPL-3.0-or-later
// Placings on simulated rigs whose [following] has one wrong number, with a sound and with a frozen sensor; and on
// sound rigs, none of which may be refused or stopped. The real tick engine, limits, placing and simulated cylinder.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "daemon/place/place_source.hpp"
#include "daemon/rig/arming.hpp"
#include "tests/unit/place/driven_rod.hpp"

namespace eha::place {
namespace {

using acquisition::Fault;
using namespace test;

bool is_refused(const config::RigConfig& rig) {
  const config::Following& following = *rig.limits.following;
  const bool parses = following.gain_positive_in_per_V_s > 0.0 && following.gain_negative_in_per_V_s > 0.0 &&
                      std::abs(following.null_V) <= 10.0 && following.limit_in > 0.0 &&
                      following.pressure_delay_s <= 10.0;
  return !parses || !arming_findings(rig).refusals.empty();
}

constexpr std::array kKeys{&config::Following::gain_positive_in_per_V_s,
                           &config::Following::gain_negative_in_per_V_s,
                           &config::Following::null_V,
                           &config::Following::dead_band_V,
                           &config::Following::limit_in,
                           &config::Following::pressure_delay_s};
constexpr std::array<const char*, 6> kNames{"gain_positive", "gain_negative", "null",
                                            "dead_band",     "limit",         "pressure_delay"};

struct Slip {
  std::size_t key = 0;
  double before = 0.0;
  double after = 0.0;
};

Slip random_slip(config::Following& following, Random& random) {
  Slip slip{.key = static_cast<std::size_t>(below(random, static_cast<int>(kKeys.size())))};
  double& value = following.*kKeys[slip.key];
  slip.before = value;
  const int kind = below(random, 4);
  if (kind == 0) value *= 10.0;
  if (kind == 1) value /= 10.0;
  if (kind == 2) value *= 25.4;
  if (kind == 3) value = with_another_digit(value, random);
  slip.after = value;
  return slip;
}

using Placed = Driven;

Placed placed(const hal::SimOptions& plant, const config::RigConfig& rig, double target_in,
              const std::optional<hal::InjectedFault>& fault) {
  const double time_s = placing_time_s(rig.limits, target_in - plant.initial_displacement_in);
  PlaceSource source(PlaceController(rig.limits, kTick_s, target_in), static_cast<std::uint32_t>(time_s / kTick_s));
  return driven(plant, rig, source, fault);
}

double random_target(const hal::SimOptions& plant, Random& random) {
  double target_in = plant.initial_displacement_in;
  while (std::abs(target_in - plant.initial_displacement_in) < 0.5) target_in = uniform(random, 0.6, 5.3);
  return target_in;
}

TEST(SlipCampaign, NeverRefusesOrStopsASoundRig) {
  const int runs = runs_wanted(1000);
  std::map<std::string, int> trips;
  for (int run = 0; run < runs; ++run) {
    Random random(1000 + static_cast<unsigned>(run));
    const hal::SimOptions plant = random_plant(random);
    const config::RigConfig rig = rig_with(commissioned(plant, random));
    ASSERT_FALSE(is_refused(rig)) << "run " << run << ": " << arming_findings(rig).refusals.front();
    const double target_in = random_target(plant, random);
    const Placed result = placed(plant, rig, target_in, std::nullopt);
    if (result.fault == Fault::none) continue;
    ++trips[std::string(to_text(result.fault))];
    ADD_FAILURE() << "run " << run << ": " << to_text(result.fault) << " at " << result.at_s << " s, to " << target_in
                  << " in from " << plant.initial_displacement_in << ", dead band " << plant.valve_dead_band_V
                  << " V, flow " << plant.valve_rated_flow_L_per_min << ", noise " << plant.sensor_noise_V
                  << " V, static friction " << plant.static_friction_N << " N";
  }
  for (const auto& [fault, count] : trips) fmt::print("false trips, {}: {}\n", fault, count);
  fmt::print("{} placings of sound rigs\n", runs);
}

struct Worst {
  int runs = 0;
  int refused = 0;
  int faster = 0;  ///< than 1 in/s
  int farther = 0;
  int ends = 0;
  double fastest_in_per_s = 0.0;
  double lost_in = 0.0;
};

TEST(SlipCampaign, KeepsASlipOfThePenSlow) {
  const int runs = runs_wanted(1000);
  std::map<std::string, Worst> worst;
  for (int run = 0; run < runs; ++run) {
    Random random(40'000 + static_cast<unsigned>(run));
    const hal::SimOptions plant = random_plant(random);
    config::Following following = commissioned(plant, random);
    const Slip slip = random_slip(following, random);
    const config::RigConfig rig = rig_with(following);
    const double target_in = random_target(plant, random);
    std::optional<hal::InjectedFault> fault;
    if (below(random, 2) == 0) {
      fault = {.kind = hal::FaultKind::stuck_sensor,
               .first_tick = below(random, 2) == 0 ? 0 : 200 + below(random, 3000),
               .ticks = hal::InjectedFault::kAlways,
               .amount = 0.0,
               .noise_LSB = uniform(random, 0.0, 30.0)};
    }
    const std::string kind = fmt::format("{:14} {}", kNames[slip.key],
                                         !fault                   ? "sound"
                                         : fault->first_tick == 0 ? "frozen from the start"
                                                                  : "freezes");
    Worst& of_kind = worst[kind];
    ++of_kind.runs;
    if (is_refused(rig)) {
      ++of_kind.refused;
      continue;
    }
    const Placed result = placed(plant, rig, target_in, fault);
    const std::string what = fmt::format(
        "run {}: {} {:.3g} for {:.3g}, {}, {} at {:.2f} s, dead band {:.2f} V, flow {:.1f}: {:.2f} in/s, {:.2f} "
        "in lost",
        run, kind, slip.after, slip.before, fault ? fault->noise_LSB : -1.0, to_text(result.fault), result.at_s,
        plant.valve_dead_band_V, plant.valve_rated_flow_L_per_min, result.fastest_in_per_s, result.lost_in);
    of_kind.fastest_in_per_s = std::max(of_kind.fastest_in_per_s, result.fastest_in_per_s);
    of_kind.lost_in = std::max(of_kind.lost_in, result.lost_in);
    if (result.fastest_in_per_s > 1.0) ++of_kind.faster;
    if (result.lost_in > 0.3) ++of_kind.farther;
    if (result.met_end_stop) ++of_kind.ends;
    EXPECT_LE(result.fastest_in_per_s, 1.0) << what;
    EXPECT_LE(result.lost_in, 0.3) << what;
    EXPECT_FALSE(result.met_end_stop) << what;
  }
  for (const auto& [kind, of_kind] : worst) {
    fmt::print(
        "{:38} {:4} runs, {:4} refused, {:3} over 1 in/s, {:3} over 0.3 in, {} at an end; at most {:.2f} in/s, {:.2f} "
        "in lost\n",
        kind, of_kind.runs, of_kind.refused, of_kind.faster, of_kind.farther, of_kind.ends, of_kind.fastest_in_per_s,
        of_kind.lost_in);
  }
}

/// Half of the sensor's slope from a moment of a long way on: a cable of two in parallel, a supply that breaks down.
TEST(SlipCampaign, FindsASlopeThatHalvesOnALongWay) {
  constexpr double kMostTime_s = 1.5;
  constexpr double kMostWay_in = 0.5;
  const int runs = runs_wanted(1000);
  std::map<std::string, int> ends;
  double longest_s = 0.0;
  double furthest_in = 0.0;
  for (int run = 0; run < runs; ++run) {
    Random random(80'000 + static_cast<unsigned>(run));
    hal::SimOptions plant = random_plant(random);
    const bool is_up = below(random, 2) == 0;
    plant.initial_displacement_in = is_up ? 1.0 : 4.9;
    const config::Following following = commissioned(plant, random);
    const config::RigConfig rig = rig_with(following);
    if (is_refused(rig)) continue;
    const double failed_s = following.pressure_delay_s + uniform(random, 1.5, 5.0);
    const Placed result =
        placed(plant, rig, is_up ? 4.7 : 1.2,
               hal::InjectedFault{.kind = hal::FaultKind::scaled_sensor,
                                  .first_tick = static_cast<std::int64_t>(std::llround(failed_s / kTick_s)),
                                  .ticks = hal::InjectedFault::kAlways,
                                  .amount = 0.5});
    ++ends[result.fault == Fault::none ? "not found" : std::string(to_text(result.fault))];
    const std::string what =
        fmt::format("run {}: {}, {:.2f} s and {:.2f} in after it failed at {:.2f} s, dead band {:.2f} V, flow {:.1f}",
                    run, to_text(result.fault), result.at_s - failed_s, result.lost_in, failed_s,
                    plant.valve_dead_band_V, plant.valve_rated_flow_L_per_min);
    EXPECT_NE(result.fault, Fault::none) << what;
    EXPECT_LE(result.at_s - failed_s, kMostTime_s) << what;
    EXPECT_LE(result.lost_in, kMostWay_in) << what;
    EXPECT_FALSE(result.met_end_stop) << what;
    longest_s = std::max(longest_s, result.at_s - failed_s);
    furthest_in = std::max(furthest_in, result.lost_in);
  }
  for (const auto& [fault, count] : ends) fmt::print("{}: {}\n", fault, count);
  fmt::print("{} slopes halved: found after {:.2f} s and {:.2f} in at most\n", runs, longest_s, furthest_in);
}

}  // namespace
}  // namespace eha::place
