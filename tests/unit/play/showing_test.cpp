// SPDX-License-Identifier: GPL-3.0-or-later
// Characterisations of rods that stand at mid-travel already, by numbers of [following] that nothing shows to be
// measured: the gains or the null's sign are wrong, and the sensor is dead.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "config/characterisation.hpp"
#include "daemon/play/source.hpp"
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

TEST(Showing, FindsADeadSensorBeforeTheVoltsOfACharacterisation) {
  int armed = 0;
  Driven worst;
  for (int run = 0; run < runs_wanted(200); ++run) {
    Random random(700'000 + static_cast<unsigned>(run));
    Drawn of_run = drawn(run % 2 == 0 ? Source::hand : Source::old_sheet, random);
    config::Following& following = of_run.following;
    if (run % 4 < 2) {
      following.gain_positive_in_per_V_s /= 10.0;
      following.gain_negative_in_per_V_s /= 10.0;
    } else {
      following.null_V = -following.null_V;
    }
    const config::RigConfig rig = rig_with(following);
    if (is_refused(rig)) continue;
    ++armed;
    const Driven did = characterised(of_run.plant, rig, dead_sensor(random));
    EXPECT_NE(did.fault, Fault::none) << "run " << run;
    EXPECT_FALSE(did.met_end_stop) << "run " << run;
    EXPECT_LE(did.lost_in, 0.4) << "run " << run << ": " << to_text(did.fault) << " at " << did.at_s << " s";
    EXPECT_LE(did.fastest_in_per_s, 1.0) << "run " << run << ": " << to_text(did.fault) << " at " << did.at_s << " s";
    worst.lost_in = std::max(worst.lost_in, did.lost_in);
    worst.fastest_in_per_s = std::max(worst.fastest_in_per_s, did.fastest_in_per_s);
  }
  EXPECT_GE(armed, 20);
  fmt::print("{} armed: at most {:.2f} in/s, {:.2f} in lost\n", armed, worst.fastest_in_per_s, worst.lost_in);
}

TEST(Showing, StopsNoSoundRod) {
  for (int run = 0; run < runs_wanted(20); ++run) {
    Random random(800'000 + static_cast<unsigned>(run));
    const Drawn of_run = drawn(run % 2 == 0 ? Source::hand : Source::old_sheet, random);
    const config::RigConfig rig = rig_with(of_run.following);
    if (is_refused(rig)) continue;
    const Driven did = characterised(of_run.plant, rig, std::nullopt);
    EXPECT_EQ(did.fault, Fault::none) << "run " << run << ": " << to_text(did.fault) << " at " << did.at_s << " s";
  }
}

}  // namespace
}  // namespace eha::play
