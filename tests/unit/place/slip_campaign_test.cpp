// SPDX-License-Identifier: GPL-3.0-or-later
// Placings on simulated rigs whose [following] has one wrong number, with a sound and with a frozen sensor; and on
// sound rigs, none of which may be refused or stopped. The real tick engine, limits, placing and simulated cylinder.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "daemon/acquisition/tick_engine.hpp"
#include "daemon/place/place_source.hpp"
#include "daemon/rig/arming.hpp"
#include "hal/faults/fault_rig.hpp"
#include "hal/sim/sim_rig.hpp"
#include "tests/unit/acquisition/true_rod.hpp"

namespace eha::place {
namespace {

using acquisition::Fault;
using Random = std::mt19937_64;

constexpr double kTick_s = 0.001;
constexpr std::int64_t kTick_ns = 1'000'000;
constexpr double kStroke_in = 150.0 / 25.4;
constexpr double kEnd_in = 0.02;  ///< a rod so near to the stop has met it

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
int below(Random& random, int count) { return std::uniform_int_distribution<int>(0, count - 1)(random); }

/// Runs of each kind; EHA_CAMPAIGN_RUNS overrides.
int runs_wanted(int usual) {
  const char* asked = std::getenv("EHA_CAMPAIGN_RUNS");
  return asked != nullptr ? std::atoi(asked) : usual;
}

/// A rod of about 0.14 or 1.2 in/(V s). Its sensor reads mid-stroke at 0 V.
hal::SimOptions random_plant(Random& random) {
  hal::SimOptions plant;
  if (below(random, 2) == 0) plant.valve_rated_flow_L_per_min *= 8.5;
  plant.valve_dead_band_V = uniform(random, 0.05, 0.6);
  plant.valve_null_offset_V = uniform(random, -0.3, 0.3);
  const double friction = std::exp(uniform(random, 0.0, std::log(5.0)));
  plant.coulomb_friction_N *= friction;
  plant.static_friction_N *= friction;
  plant.viscous_friction_N_s_per_mm *= friction;
  plant.friction_regularisation_mm_per_s *= friction;
  plant.moving_mass_kg *= uniform(random, 1.0, 3.0);
  plant.scale_in_per_V = 0.295;
  plant.offset_in = 2.95;
  plant.initial_displacement_in = uniform(random, 1.0, 4.9);
  plant.sensor_noise_V = uniform(random, 0.0003, 0.005);
  plant.seed = random();
  return plant;
}

double steady_speed(const hal::SimOptions& plant, double command_V) {
  hal::SimOptions quiet = plant;
  quiet.sensor_noise_V = 0.0;
  quiet.initial_displacement_in = 2.95;
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(quiet, 0.0);
  hal::AppliedCommand applied;
  hal::RigReading before;
  hal::RigReading after;
  EXPECT_EQ(rig->command(command_V, applied), hal::RigStatus::ok);
  EXPECT_EQ(rig->set_enable(true), hal::RigStatus::ok);
  EXPECT_EQ(rig->read(300'000'000, before), hal::RigStatus::ok);
  EXPECT_EQ(rig->read(500'000'000, after), hal::RigStatus::ok);
  return (after.displacement_in - before.displacement_in) / 0.2;
}

/// What commissioning finds: the gains from a step each way, the null to 0.03 V, the dead band and 0.05 V.
config::Following commissioned(const hal::SimOptions& plant, Random& random) {
  const double null_V = -plant.valve_null_offset_V;
  const double outside_V = 1.5;
  const double step_V = plant.valve_dead_band_V + outside_V;
  return {.gain_positive_in_per_V_s = 0.5 * steady_speed(plant, null_V + step_V) / outside_V,
          .gain_negative_in_per_V_s = -0.5 * steady_speed(plant, null_V - step_V) / outside_V,
          .null_V = null_V + uniform(random, -0.03, 0.03),
          .dead_band_V = plant.valve_dead_band_V + 0.05,
          .limit_in = 0.1,
          .pressure_delay_s = below(random, 2) == 0 ? 0.0 : uniform(random, 0.1, 1.0)};
}

/// A rig file that moves a machine, with these numbers of its valve.
config::RigConfig rig_with(const config::Following& following) {
  static const config::RigConfig card = config::load_rig(EHA_SOURCE_DIR "/config/rigs/pci1716.toml");
  config::RigConfig rig = card;
  rig.is_sample = false;
  rig.limits.following = following;
  return rig;
}

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

/// Another digit in one place of a number of three digits.
double with_another_digit(double value, Random& random) {
  std::string text = fmt::format("{:.3g}", value);
  std::vector<std::size_t> digits;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (std::isdigit(static_cast<unsigned char>(text[i])) != 0) digits.push_back(i);
  }
  char& digit = text[digits[static_cast<std::size_t>(below(random, static_cast<int>(digits.size())))]];
  digit = static_cast<char>('0' + (digit - '0' + 1 + below(random, 9)) % 10);
  return std::stod(text);
}

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

struct Placed {
  Fault fault = Fault::none;
  double at_s = 0.0;
  double fastest_in_per_s = 0.0;  ///< true speed over 50 ms
  double lost_in = 0.0;           ///< true way after the sensor failed
  bool met_end_stop = false;
};

Placed placed(const hal::SimOptions& plant, const config::RigConfig& rig, double target_in,
              const std::optional<hal::InjectedFault>& fault) {
  const std::unique_ptr<hal::Rig> sim = hal::open_rig(plant, rig.limits.safe_V);
  acquisition::TrueRod rod(*sim);
  std::vector<hal::InjectedFault> faults;
  if (fault) faults.push_back(*fault);
  hal::FaultRig sensed(
      rod, faults, [](std::int64_t) {}, plant.conversion());
  acquisition::StateMachine machine;
  machine.reset();
  machine.arm();
  acquisition::VirtualClock clock;
  const double time_s = placing_time_s(rig.limits, target_in - plant.initial_displacement_in);
  PlaceSource source(PlaceController(rig.limits, kTick_s, target_in), static_cast<std::uint32_t>(time_s / kTick_s));
  acquisition::TickEngine engine(sensed, machine, source, rig.limits, {}, acquisition::LatePolicy::abort, clock);
  Placed result;
  std::vector<double> sums{0.0};
  double failed_in = 0.0;
  // Half a second more: the rod comes to rest.
  std::int64_t rest = 500;
  for (std::int64_t k = 0; rest > 0; ++k) {
    if (engine.finished()) {
      --rest;
      hal::RigReading ignored;
      (void)rod.read(k * kTick_ns, ignored);
    } else {
      acquisition::TickInputs inputs;
      inputs.sequence = static_cast<std::uint32_t>(k);
      inputs.scheduled_ns = k * kTick_ns;
      (void)engine.tick(inputs);
    }
    sums.push_back(sums.back() + rod.place_in);
    if (k >= 60) {
      // Means of ten readings, 50 ms apart: the plant's readings are noisy.
      const auto mean_in = [&](std::int64_t from) {
        return (sums[static_cast<std::size_t>(from + 10)] - sums[static_cast<std::size_t>(from)]) / 10.0;
      };
      result.fastest_in_per_s = std::max(result.fastest_in_per_s, std::abs(mean_in(k - 9) - mean_in(k - 59)) / 0.05);
    }
    if (fault && k <= fault->first_tick) failed_in = rod.place_in;
    if (fault && k > fault->first_tick) result.lost_in = std::max(result.lost_in, std::abs(rod.place_in - failed_in));
    result.met_end_stop = result.met_end_stop || rod.place_in < kEnd_in || rod.place_in > kStroke_in - kEnd_in;
  }
  result.fault = engine.fault().fault;
  result.at_s = static_cast<double>(engine.fault().at_ns) * 1e-9;
  return result;
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

}  // namespace
}  // namespace eha::place
