// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/measured_check.hpp"
#include "daemon/place/place_source.hpp"
#include "daemon/place/pressure_source.hpp"
#include "daemon/rig/arming.hpp"
#include "tests/unit/place/driven_rod.hpp"

// Rigs with [following] whose owner may have made a slip of the pen, and what moves their rods.

namespace eha::test {

inline bool is_refused(const config::RigConfig& rig) {
  const config::Following& following = *rig.limits.following;
  const bool parses = following.gain_positive_in_per_V_s > 0.0 && following.gain_negative_in_per_V_s > 0.0 &&
                      std::abs(following.null_V) <= 10.0 && following.limit_in > 0.0 &&
                      following.pressure_delay_s <= 10.0 && following.null_uncertainty_V.value_or(0.0) <= 10.0 &&
                      following.dead_band_uncertainty_V.value_or(0.0) <= 10.0 &&
                      following.gain_uncertainty_percent.value_or(0.0) <= 100.0;
  return !parses || !arming_findings(rig).refusals.empty();
}

/// Where the numbers of a rig file come from.
enum class Source {
  hand,       ///< slow steps
  old_sheet,  ///< of a characterisation, without its sum
  sheet,      ///< of a characterisation, with its sum
};
inline constexpr std::array kSources{Source::hand, Source::old_sheet, Source::sheet};
inline constexpr std::array<const char*, 3> kSourceNames{"by hand", "old sheet", "sheet"};

/// What `eha characterise` writes for this rod. @param with_sum  as it does now
inline void add_uncertainties(config::Following& following, Random& random, bool with_sum) {
  following.null_uncertainty_V = uniform(random, 0.003, 0.04);
  following.dead_band_uncertainty_V = uniform(random, 0.003, 0.04);
  following.gain_uncertainty_percent = uniform(random, 0.3, 3.0);
  if (!with_sum) return;
  following.measured_check = config::measured_check_of(following);
  following.measured_rig_check = config::measured_rig_check_of(rig_with(following).backend);
}

/// A rod and the file of its rig. A rod of more than 1 in/s over its dead band is armed with a sheet only.
struct Drawn {
  hal::SimOptions plant;
  config::Following following;
};

inline Drawn drawn(Source source, Random& random) {
  Drawn found{.plant = random_plant(random), .following = {}};
  if (source == Source::sheet) found.plant.valve_rated_flow_L_per_min *= uniform(random, 1.0, 2.0);
  found.following = commissioned(found.plant, random);
  if (found.following.pressure_delay_s > 0.0) found.following.pressure_delay_s = uniform(random, 0.1, 3.0);
  if (source != Source::hand) add_uncertainties(found.following, random, source == Source::sheet);
  return found;
}

struct Key {
  const char* name;
  double* value;
};

inline std::vector<Key> keys_of(config::Following& following) {
  std::vector<Key> keys{{"gain_positive", &following.gain_positive_in_per_V_s},
                        {"gain_negative", &following.gain_negative_in_per_V_s},
                        {"null", &following.null_V},
                        {"dead_band", &following.dead_band_V},
                        {"limit", &following.limit_in},
                        {"pressure_delay", &following.pressure_delay_s}};
  if (!following.dead_band_uncertainty_V) return keys;
  keys.push_back({"null_uncertainty", &*following.null_uncertainty_V});
  keys.push_back({"dead_band_uncertainty", &*following.dead_band_uncertainty_V});
  keys.push_back({"gain_uncertainty", &*following.gain_uncertainty_percent});
  return keys;
}

struct Slip {
  std::string key;
  double before = 0.0;
  double after = 0.0;
};

inline Slip random_slip(config::Following& following, Random& random) {
  std::vector<Key> keys = keys_of(following);
  double sum = 0.0;
  std::uint32_t* check = nullptr;
  if (following.measured_check) {
    keys.push_back({"measured_check", &sum});
    keys.push_back({"measured_rig_check", &sum});
  }
  const Key& key = keys[static_cast<std::size_t>(below(random, static_cast<int>(keys.size())))];
  if (key.value == &sum) {
    check = &*(key.name == std::string("measured_check") ? following.measured_check : following.measured_rig_check);
    sum = *check;
  }
  Slip slip{.key = key.name, .before = *key.value};
  if (check != nullptr) {
    const int place = below(random, 10);
    sum = std::fmod(sum + std::round(std::pow(10.0, place)) * (1 + below(random, 9)), 4294967296.0);
    *check = static_cast<std::uint32_t>(sum);
  } else {
    const int kind = below(random, 5);
    if (kind == 0) *key.value *= 10.0;
    if (kind == 1) *key.value /= 10.0;
    if (kind == 2) *key.value *= 25.4;
    if (kind == 3) *key.value = with_another_digit(*key.value, random);
    if (kind == 4) *key.value = -*key.value;
  }
  slip.after = *key.value;
  return slip;
}

using Placed = Driven;

inline Placed placed(const hal::SimOptions& plant, const config::RigConfig& rig, double target_in,
                     const std::optional<hal::InjectedFault>& fault) {
  const double time_s = place::placing_time_s(rig.limits, target_in - plant.initial_displacement_in);
  const double tick_s = rig.realtime.sample_period_s;
  place::PlaceSource source(place::PlaceController(rig.limits, tick_s, target_in),
                            static_cast<std::uint32_t>(time_s / tick_s));
  return driven(plant, rig, source, fault);
}

/// An experiment without [start] whose volts are the valve's own null: only the wait for the pressure moves the rod.
inline Placed waited(const hal::SimOptions& plant, const config::RigConfig& rig,
                     const std::optional<hal::InjectedFault>& fault) {
  const std::vector<double> table_V(1000, -plant.valve_null_offset_V);
  place::PressureSource source(*rig.limits.following, rig.realtime.sample_period_s,
                               std::make_unique<acquisition::TableSource>(table_V, 1));
  return driven(plant, rig, source, fault);
}

/// A wait, of every other rig with a pressure delay, or a placing.
inline Placed played(const hal::SimOptions& plant, const config::RigConfig& rig, double target_in,
                     const std::optional<hal::InjectedFault>& fault, Random& random) {
  const bool waits = rig.limits.following->pressure_delay_s > 0.0 && below(random, 2) == 0;
  return waits ? waited(plant, rig, fault) : placed(plant, rig, target_in, fault);
}

inline constexpr double kFromEnd_in = 0.6;
/// The stopping distance from the velocity limit of 8 in/s is 0.56 in at a tick of 50 ms.
inline constexpr double kFromEndAtALongTick_in = 0.9;

/// @param to_end_in  least distance from an end stop
inline double random_target(const hal::SimOptions& plant, Random& random, double to_end_in = kFromEnd_in) {
  double target_in = plant.initial_displacement_in;
  while (std::abs(target_in - plant.initial_displacement_in) < 0.5) {
    target_in = uniform(random, to_end_in, 5.9 - to_end_in);
  }
  return target_in;
}

}  // namespace eha::test
