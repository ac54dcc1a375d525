// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/tune/expected_trip.hpp"

#include <gtest/gtest.h>

#include "hal/backends/backend.hpp"
#include "tests/unit/acquisition/tracked.hpp"

namespace eha::tune {
namespace {

TEST(ExpectedTrip, IsNoneOfARodThatIsBroughtBackFromBeyondALimit) {
  const config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  auto sim = std::get<hal::SimOptions>(rig.backend);
  config::Track still = acquisition::tracked(rig.limits.mid_travel_in(), rig.limits.mid_travel_in(), 20.0);
  still.controller.settings.inverse = {
      .null = -0.2, .dead_band = 0.15, .gain_positive = 0.148, .gain_negative = 0.13, .smoothing = 0.05};
  sim.initial_displacement_in = rig.limits.mid_travel_in();
  EXPECT_FALSE(expected_trip(still, rig.limits, sim));
  sim.initial_displacement_in = rig.limits.travel_max_in + 0.1;
  EXPECT_FALSE(expected_trip(still, rig.limits, sim));
  sim.initial_displacement_in = rig.limits.travel_max_in - 0.1;
  EXPECT_TRUE(expected_trip(still, rig.limits, sim)) << "far from its reference, where a trial would begin";
}

}  // namespace
}  // namespace eha::tune
