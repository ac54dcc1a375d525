// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "config/valve_estimate.hpp"
#include "daemon/tune/twin_draws.hpp"
#include "hal/backends/backend.hpp"

namespace eha::tune {
namespace {

TEST(TwinFollowing, IsThatOfTheShippedRigForItsOwnValve) {
  const config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  const config::Following& shipped = *rig.limits.following;
  const config::Following found = following_of(std::get<hal::SimOptions>(rig.backend), shipped);
  EXPECT_NEAR(found.null_V, shipped.null_V, 1e-9);
  EXPECT_NEAR(found.dead_band_V, shipped.dead_band_V, 1e-9);
  EXPECT_NEAR(found.gain_positive_in_per_V_s, shipped.gain_positive_in_per_V_s, 0.003);
  EXPECT_NEAR(found.gain_negative_in_per_V_s, shipped.gain_negative_in_per_V_s, 0.003);
  EXPECT_EQ(found.limit_in, shipped.limit_in);
}

}  // namespace
}  // namespace eha::tune
