// SPDX-License-Identifier: GPL-3.0-or-later
// Characterisations and experiments of rods that stand at their start already, with numbers of [following] that nothing
// shows to be measured: the gains or the null's sign are wrong, or the sensor is dead.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "config/characterisation.hpp"
#include "daemon/play/volts_source.hpp"
#include "tests/unit/place/slip_rig.hpp"

namespace eha::play {
namespace {

using acquisition::Fault;
using namespace test;

/// Characterises a rod that stands where the run wants it.
Driven characterised(hal::SimOptions plant, const config::RigConfig& rig,
                     const std::optional<hal::InjectedFault>& fault) {
  plant.initial_displacement_in = config::centring_of(rig.limits).middle_in;
  const ident::SheetPlan plan = config::characterisation_plan(rig);
  config::ExperimentConfig experiment;
  experiment.kind = config::SheetRun{};
  const PlayRequest request{.rig = rig,
                            .experiment = experiment,
                            .table_V = {plan.table_V.data(), static_cast<std::size_t>(plan.table_V.size())},
                            .folder = {}};
  return driven(plant, rig, *make_source(request), fault);
}

/// Reads mid-travel, with noise.
hal::InjectedFault dead_sensor(Random& random) {
  return {.kind = hal::FaultKind::stuck_sensor,
          .first_tick = 0,
          .ticks = hal::InjectedFault::kAlways,
          .noise_LSB = uniform(random, 0.5, 30.0)};
}

/// Plays a sine that by the file moves the rod at 0.6 in/s, from where it stands.
Driven swung(hal::SimOptions plant, const config::RigConfig& rig, const std::optional<hal::InjectedFault>& fault) {
  plant.initial_displacement_in = config::centring_of(rig.limits).middle_in;
  const config::Following& following = *rig.limits.following;
  const double gain = 2.0 * std::min(following.gain_positive_in_per_V_s, following.gain_negative_in_per_V_s);
  const double room_V =
      std::min(rig.limits.command_max_V - following.null_V, following.null_V - rig.limits.command_min_V);
  const double amplitude_V = std::min(following.dead_band_V + 0.6 / gain, 0.95 * room_V);
  std::vector<double> table_V(static_cast<std::size_t>(10.0 / rig.realtime.sample_period_s));
  for (std::size_t k = 0; k < table_V.size(); ++k) {
    const double time_s = static_cast<double>(k) * rig.realtime.sample_period_s;
    table_V[k] = following.null_V + amplitude_V * std::sin(2.0 * std::numbers::pi * 0.4 * time_s);
  }
  config::ExperimentConfig experiment;
  experiment.kind = config::Played{};
  const PlayRequest request{.rig = rig, .experiment = experiment, .table_V = table_V, .folder = {}};
  return driven(plant, rig, *make_source(request), fault);
}

/// Expects of 200 drawn rigs with a wrong number that each one that is armed trips before it is fast or far.
/// @param drive  spoils what was drawn for a run, and drives it; none: it is not armed
void expect_trips_in_time(unsigned seed, int fewest_armed,
                          const std::function<std::optional<Driven>(int run, Drawn&, Random&)>& drive) {
  int armed = 0;
  Driven worst;
  for (int run = 0; run < runs_wanted(200); ++run) {
    Random random(seed + static_cast<unsigned>(run));
    Drawn of_run = drawn(run % 2 == 0 ? Source::hand : Source::old_sheet, random);
    const std::optional<Driven> did = drive(run, of_run, random);
    if (!did) continue;
    ++armed;
    EXPECT_NE(did->fault, Fault::none) << "run " << run;
    EXPECT_FALSE(did->met_end_stop) << "run " << run;
    EXPECT_LE(did->lost_in, 0.4) << "run " << run << ": " << to_text(did->fault) << " at " << did->at_s << " s";
    EXPECT_LE(did->fastest_in_per_s, 1.0) << "run " << run << ": " << to_text(did->fault) << " at " << did->at_s;
    worst.lost_in = std::max(worst.lost_in, did->lost_in);
    worst.fastest_in_per_s = std::max(worst.fastest_in_per_s, did->fastest_in_per_s);
  }
  EXPECT_GE(armed, fewest_armed);
  fmt::print("{} armed: at most {:.2f} in/s, {:.2f} in lost\n", armed, worst.fastest_in_per_s, worst.lost_in);
}

void divide_gains(config::Following& following) {
  following.gain_positive_in_per_V_s /= 10.0;
  following.gain_negative_in_per_V_s /= 10.0;
}

TEST(Showing, FindsADeadSensorBeforeTheVoltsOfACharacterisation) {
  expect_trips_in_time(700'000, 20, [](int run, Drawn& of_run, Random& random) -> std::optional<Driven> {
    config::Following& following = of_run.following;
    if (run % 4 < 2) {
      divide_gains(following);
    } else {
      following.null_V = -following.null_V;
    }
    const config::RigConfig rig = rig_with(following);
    if (is_refused(rig)) return std::nullopt;
    return characterised(of_run.plant, rig, dead_sensor(random));
  });
}

TEST(Showing, FindsGainsOfATenthBeforeTheVoltsOfAnExperiment) {
  expect_trips_in_time(900'000, 10, [](int run, Drawn& of_run, Random& random) -> std::optional<Driven> {
    divide_gains(of_run.following);
    const config::RigConfig rig = rig_with(of_run.following);
    if (is_refused(rig)) return std::nullopt;
    return swung(of_run.plant, rig, run % 4 < 2 ? std::optional(dead_sensor(random)) : std::nullopt);
  });
}

TEST(Showing, StopsNoSoundRod) {
  for (int run = 0; run < runs_wanted(20); ++run) {
    Random random(800'000 + static_cast<unsigned>(run));
    const Drawn of_run = drawn(run % 2 == 0 ? Source::hand : Source::old_sheet, random);
    config::RigConfig rig = rig_with(of_run.following);
    // A placing takes the command to be at the null when it begins.
    if (run % 3 == 0) rig.limits.slew_V_per_s = 2.6;
    if (is_refused(rig)) continue;
    const Driven did =
        run % 4 < 2 ? characterised(of_run.plant, rig, std::nullopt) : swung(of_run.plant, rig, std::nullopt);
    EXPECT_EQ(did.fault, Fault::none) << "run " << run << ": " << to_text(did.fault) << " at " << did.at_s << " s";
  }
}

}  // namespace
}  // namespace eha::play
