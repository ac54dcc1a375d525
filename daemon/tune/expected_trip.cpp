// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/tune/expected_trip.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>

#include "core/capitalised.hpp"
#include "core/inch.hpp"
#include "daemon/acquisition/command_chain.hpp"
#include "daemon/acquisition/following_monitor.hpp"
#include "daemon/track/track_source.hpp"
#include "hal/converter.hpp"
#include "hal/sim/cylinder.hpp"
#include "hal/sim/normal_noise.hpp"
#include "ident/valve/leak.hpp"

namespace eha::tune {
namespace {

using acquisition::Breach;
using acquisition::Fault;

std::optional<ExpectedTrip> first_trip(const config::Track& track, const config::RigLimits& limits,
                                       const hal::SimOptions& rig) {
  const double tick_s = track.controller.settings.tick_s;
  hal::Cylinder cylinder(rig);
  const hal::Converter output(rig.command_min_V, rig.command_max_V, rig.resolution_bits);
  const hal::Converter input(rig.feedback_min_V, rig.feedback_max_V, rig.resolution_bits);
  hal::NormalNoise noise(rig.seed);
  track::TrackSource source(track, limits);
  acquisition::FollowingMonitor following(acquisition::following_rule(limits));
  acquisition::CommandChain chain(limits, tick_s);
  following.begin(0);
  double applied_V = chain.plan(limits.safe_V).command_V;
  for (std::uint32_t row = 0; row < source.rows(); ++row) {
    const double at_s = tick_s * row;
    const double rod_in = cylinder.state().displacement_m / kMetrePerInch;
    const double exact_V = (rod_in - rig.offset_in) / rig.scale_in_per_V;
    hal::RigReading reading;
    reading.displacement_in =
        rig.offset_in + rig.scale_in_per_V * input.volts(input.code(exact_V + rig.sensor_noise_V * noise()));
    const Breach late =
        following.check(static_cast<std::int64_t>(std::llround(1e9 * at_s)), reading.displacement_in, applied_V);
    const double wanted_V = source.voltage_V(row, reading);
    const Breach breach = late.fault != Fault::none ? late : source.breach();
    if (breach.fault != Fault::none) return ExpectedTrip{breach, at_s, applied_V};
    applied_V = output.volts(output.code(chain.plan(wanted_V).command_V));
    chain.accept(applied_V);
    cylinder.advance_implicitly(applied_V, hal::Ports::open, tick_s);
  }
  return std::nullopt;
}

}  // namespace

std::optional<ExpectedTrip> expected_trip(const config::Track& track, const config::RigLimits& limits,
                                          const hal::SimOptions& rig) {
  hal::SimOptions begun = rig;
  // A rod beyond a limit is brought back before any trial.
  const bool is_beyond =
      rig.initial_displacement_in < limits.travel_min_in || rig.initial_displacement_in > limits.travel_max_in;
  if (is_beyond) begun.initial_displacement_in = limits.mid_travel_in();
  std::optional<ExpectedTrip> trip = first_trip(track, limits, begun);
  if (!trip || !(rig.leakage_cm3_per_s_per_bar > 0.0)) return trip;
  hal::SimOptions tight = begun;
  tight.leakage_cm3_per_s_per_bar = 0.0;
  trip->is_of_leak = !first_trip(track, limits, tight).has_value();
  return trip;
}

std::string sentence_of(const ExpectedTrip& trip, const config::RigLimits& limits) {
  std::string text =
      fmt::format("{}: {} after some {:.0f} s", kTrialTrips, acquisition::to_text(trip.breach.fault), trip.at_s);
  const bool misses_motion = trip.breach.fault == Fault::no_motion || trip.breach.fault == Fault::not_following;
  if (misses_motion && limits.following) {
    text += fmt::format(
        ". The rod stands only under {:.2f} V, {:.2f} V from the null, where the checks of [following] expect motion "
        "(dead_band_V is {:.2f} V)",
        trip.command_V, std::abs(trip.command_V - limits.following->null_V), limits.following->dead_band_V);
  }
  text += trip.is_of_leak
              ? fmt::format(", because oil leaks past the piston: without the leak the same trial passes. {}.",
                            capitalised(ident::kRepairFirst))
              : std::string(". Measure the valve (`eha characterise`), then `eha tune`.");
  return text;
}

}  // namespace eha::tune
