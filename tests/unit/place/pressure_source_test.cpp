// SPDX-License-Identifier: GPL-3.0-or-later
// A table of volts on simulated rods whose sensor freezes while the pressure builds up.
#include "daemon/place/pressure_source.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "tests/unit/place/driven_rod.hpp"

namespace eha::place {
namespace {

using namespace test;
using Stage = acquisition::CommandSource::Stage;

constexpr double kDelay_s = 3.0;  ///< the longest that is armed

/// A sine about the null that moves the rod by about 0.4 in.
std::vector<double> sine_of(const config::Following& following, double frequency_Hz, double duration_s) {
  const double gain = following.gain_positive_in_per_V_s + following.gain_negative_in_per_V_s;
  const double outside_V = 0.4 * std::numbers::pi * frequency_Hz / gain;
  const double amplitude_V = std::min(4.5, following.dead_band_V + outside_V);
  std::vector<double> table_V(static_cast<std::size_t>(duration_s / kTick_s));
  for (std::size_t k = 0; k < table_V.size(); ++k) {
    const double turns = frequency_Hz * kTick_s * static_cast<double>(k);
    table_V[k] = following.null_V + amplitude_V * std::sin(2.0 * std::numbers::pi * turns);
  }
  return table_V;
}

TEST(PressureSource, KeepsTheNullUntilThePressureHasBuiltUp) {
  const std::vector<double> table_V{1.0, 2.0};
  PressureSource source({.null_V = 0.1, .pressure_delay_s = 0.0035}, 0.001,
                        std::make_unique<acquisition::TableSource>(table_V, 3));
  EXPECT_EQ(source.rows(), 6U);
  EXPECT_EQ(source.rows_per_repetition(), 2U);
  const hal::RigReading reading;
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(source.voltage_V(0, reading), 0.1) << k;
    EXPECT_EQ(source.stage(), Stage::preparing) << k;
  }
  EXPECT_EQ(source.voltage_V(0, reading), 1.0);
  EXPECT_EQ(source.stage(), Stage::playing);
  EXPECT_EQ(source.voltage_V(1, reading), 2.0);
}

TEST(PressureSource, LeavesNoTimeInWhichADeadSensorIsNotFound) {
  const int runs = runs_wanted(20);
  double furthest_in = 0.0;
  for (int run = 0; run < runs; ++run) {
    Random random(600 + static_cast<unsigned>(run));
    const hal::SimOptions plant = random_plant(random);
    config::Following following = commissioned(plant, random);
    following.pressure_delay_s = kDelay_s;
    const config::RigConfig rig = rig_with(following);
    const std::vector<double> table_V = sine_of(following, uniform(random, 0.05, 0.5), 5.0);
    PressureSource source(following, kTick_s, std::make_unique<acquisition::TableSource>(table_V, 1));
    const Driven result = driven(plant, rig, source,
                                 hal::InjectedFault{.kind = hal::FaultKind::stuck_sensor,
                                                    .first_tick = 50,
                                                    .ticks = hal::InjectedFault::kAlways,
                                                    .amount = 0.0,
                                                    .noise_LSB = uniform(random, 2.0, 20.0)});
    EXPECT_FALSE(result.met_end_stop) << run;
    EXPECT_LE(result.lost_in, 0.5) << run;
    furthest_in = std::max(furthest_in, result.lost_in);
  }
  fmt::print("{} rods: lost at most {:.2f} in\n", runs, furthest_in);
}

}  // namespace
}  // namespace eha::place
