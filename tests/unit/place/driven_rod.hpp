// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "config/rig_config.hpp"
#include "daemon/acquisition/tick_engine.hpp"
#include "hal/faults/fault_rig.hpp"
#include "hal/sim/sim_rig.hpp"
#include "tests/unit/acquisition/true_rod.hpp"

namespace eha::test {

using acquisition::Fault;
using Random = std::mt19937_64;

inline constexpr double kTick_s = 0.001;
inline constexpr std::int64_t kTick_ns = 1'000'000;
inline constexpr double kStroke_in = 150.0 / 25.4;
inline constexpr double kEnd_in = 0.02;  ///< a rod so near to the stop has met it

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
inline int below(Random& random, int count) { return std::uniform_int_distribution<int>(0, count - 1)(random); }

/// Runs of each kind; EHA_CAMPAIGN_RUNS overrides.
inline int runs_wanted(int usual) {
  const char* asked = std::getenv("EHA_CAMPAIGN_RUNS");
  return asked != nullptr ? std::atoi(asked) : usual;
}

/// Added to the seeds of a campaign: other draws.
inline unsigned first_wanted() {
  const char* asked = std::getenv("EHA_CAMPAIGN_FIRST");
  return asked != nullptr ? static_cast<unsigned>(std::atoi(asked)) : 0;
}

/// A rod of about 0.14 or 1.2 in/(V s). Its sensor reads mid-stroke at 0 V.
inline hal::SimOptions random_plant(Random& random) {
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

inline double steady_speed(const hal::SimOptions& plant, double command_V) {
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
inline config::Following commissioned(const hal::SimOptions& plant, Random& random) {
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
inline config::RigConfig rig_with(const config::Following& following) {
  static const config::RigConfig card = config::load_rig(EHA_SOURCE_DIR "/config/rigs/pci1716.toml");
  config::RigConfig rig = card;
  rig.is_sample = false;
  rig.limits.following = following;
  return rig;
}

/// Another digit in one place of a number of three digits.
inline double with_another_digit(double value, Random& random) {
  std::string text = fmt::format("{:.3g}", value);
  std::vector<std::size_t> digits;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (std::isdigit(static_cast<unsigned char>(text[i])) != 0) digits.push_back(i);
  }
  char& digit = text[digits[static_cast<std::size_t>(below(random, static_cast<int>(digits.size())))]];
  digit = static_cast<char>('0' + (digit - '0' + 1 + below(random, 9)) % 10);
  return std::stod(text);
}

/// What a rod did in a driven run.
struct Driven {
  Fault fault = Fault::none;
  double at_s = 0.0;
  double fastest_in_per_s = 0.0;  ///< true speed over 50 ms
  double lost_in = 0.0;           ///< true way after the sensor failed or the stop was asked for
  bool met_end_stop = false;
};

/// Drives a simulated rod by a source of volts through the real tick engine, and half a second more, in which it rests.
/// The tick is the rig's, in whole milliseconds; the true place is looked at every millisecond.
/// @param fault, stop_tick  count ticks; stop_tick: at which a user's stop is asked for; none: never
inline Driven driven(const hal::SimOptions& plant, const config::RigConfig& rig, acquisition::CommandSource& source,
                     const std::optional<hal::InjectedFault>& fault, std::optional<std::int64_t> stop_tick = {}) {
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
  const std::int64_t tick_ms = std::llround(rig.realtime.sample_period_s / kTick_s);
  config::RealtimeOptions realtime;
  realtime.sample_period_s = rig.realtime.sample_period_s;
  acquisition::TickEngine engine(sensed, machine, source, rig.limits, realtime, acquisition::LatePolicy::abort, clock);
  Driven result;
  std::vector<double> sums{0.0};
  double failed_in = 0.0;
  const std::int64_t event_ms =
      tick_ms * (fault ? fault->first_tick : stop_tick.value_or(hal::InjectedFault::kAlways / tick_ms));
  // Half a second more: the rod comes to rest.
  std::int64_t rest = 500;
  for (std::int64_t k = 0; rest > 0; ++k) {
    if (engine.finished()) --rest;
    if (engine.finished() || k % tick_ms != 0) {
      hal::RigReading ignored;
      (void)rod.read(k * kTick_ns, ignored);
    } else {
      acquisition::TickInputs inputs;
      inputs.sequence = static_cast<std::uint32_t>(k / tick_ms);
      inputs.scheduled_ns = k * kTick_ns;
      inputs.stops = stop_tick && k >= event_ms ? 1 : 0;
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
    if (k <= event_ms) failed_in = rod.place_in;
    if (k > event_ms) result.lost_in = std::max(result.lost_in, std::abs(rod.place_in - failed_in));
    result.met_end_stop = result.met_end_stop || rod.place_in < kEnd_in || rod.place_in > kStroke_in - kEnd_in;
  }
  result.fault = engine.fault().fault;
  result.at_s = static_cast<double>(engine.fault().at_ns) * 1e-9;
  return result;
}

}  // namespace eha::test
