// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/sim/sim_options.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace eha::hal {
namespace {

std::string keys(const SimOptions& options) {
  std::string list;
  for (const OptionIssue& fault : check(options)) list += (list.empty() ? "" : " ") + fault.key;
  return list;
}

TEST(SimOptions, AreSoundAndUntamedAsShipped) {
  const SimOptions o;
  EXPECT_EQ(keys(o), "");
  EXPECT_NEAR(o.bore_mm * o.bore_mm / (o.bore_mm * o.bore_mm - o.rod_mm * o.rod_mm), 1.333, 0.001);
  EXPECT_GT(o.valve_dead_band_V, 0.0);
  EXPECT_GT(o.valve_null_offset_V, 0.0);
  EXPECT_GT(o.coulomb_friction_N, 0.0);
  EXPECT_GT(o.static_friction_N, o.coulomb_friction_N);
  EXPECT_GT(o.leakage_cm3_per_s_per_bar, 0.0);
}

TEST(SimOptions, NameEveryFaultAtOnce) {
  SimOptions o;
  o.bore_mm = -1.0;
  o.initial_displacement_in = 6.0;
  o.static_friction_N = 10.0;
  o.command_min_V = 10.0;
  o.resolution_bits = 40;
  o.scale_in_per_V = 0.0;
  o.sensor_noise_V = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(keys(o),
            "bore_mm rod_mm initial_displacement_in static_friction_N command_min_V resolution_bits scale_in_per_V "
            "sensor_noise_V");
}

TEST(SimOptions, RefuseAStepThatTheIntegrationCannotFollow) {
  SimOptions o;
  o.sub_step_us = 400.0;
  EXPECT_EQ(keys(o), "sub_step_us");
  o.sub_step_us = 1e-7;
  EXPECT_EQ(keys(o), "sub_step_us") << "a tick would not end";
  o = SimOptions();
  o.friction_regularisation_mm_per_s = 0.01;
  EXPECT_EQ(keys(o), "sub_step_us");
}

}  // namespace
}  // namespace eha::hal
