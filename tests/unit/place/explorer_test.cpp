// SPDX-License-Identifier: GPL-3.0-or-later
// The slow way through travel where the rod has not been, on the simulated rig.
#include "daemon/place/explorer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>

#include "hal/sim/sim_rig.hpp"
#include "tests/unit/place/long_play.hpp"

namespace eha::place {
namespace {

constexpr double kWindow_in = 1.6;

struct Exploration {
  acquisition::Breach breach;
  Explored explored;
  double fastest_new_in_per_s = 0.0;       ///< over 0.1 s, in travel where the rod had not been
  double fastest_outwards_in_per_s = 0.0;  ///< over 1 s, beyond the window
  double time_s = 0.0;
};

/// @param factor  of the sensor's scale about the middle of the stroke
Exploration exploration(hal::SimOptions options, double factor) {
  options.sensor_noise_V = 0.0002;
  const config::RigLimits limits = limits_of_the_simulated_rig();
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(options, 0.0);
  Explorer explorer(limits, kWindow_in, 0.001);
  hal::AppliedCommand applied;
  hal::RigReading reading;
  rig->set_enable(true);
  Exploration result;
  double lowest_in = options.initial_displacement_in;
  double highest_in = lowest_in;
  double before_in = lowest_in;
  double second_before_in = lowest_in;
  for (int k = 0; !explorer.is_done() && explorer.breach().fault == acquisition::Fault::none; ++k) {
    rig->read(static_cast<std::int64_t>(k) * 1'000'000, reading);
    const double true_in = reading.displacement_in;
    if (k % 100 == 0) {
      if (true_in < lowest_in || true_in > highest_in) {
        result.fastest_new_in_per_s = std::max(result.fastest_new_in_per_s, std::abs(true_in - before_in) / 0.1);
      }
      lowest_in = std::min(lowest_in, true_in);
      highest_in = std::max(highest_in, true_in);
      before_in = true_in;
    }
    if (k % 1000 == 0) {
      const double outwards_in = std::abs(true_in - 2.95) - std::abs(second_before_in - 2.95);
      if (std::abs(factor * (true_in - 2.95)) > kWindow_in) {
        result.fastest_outwards_in_per_s = std::max(result.fastest_outwards_in_per_s, outwards_in);
      }
      second_before_in = true_in;
    }
    reading.displacement_in = 2.95 + factor * (true_in - 2.95);
    rig->command(explorer.voltage_V(reading), applied);
    result.time_s = 0.001 * k;
  }
  result.breach = explorer.breach();
  result.explored = explorer.explored();
  return result;
}

TEST(Explorer, GoesThroughItsWindowSlowlyAndFindsTheNull) {
  for (const double flow : {0.6, 1.2, 10.0}) {
    hal::SimOptions options;
    options.valve_rated_flow_L_per_min = flow;
    const Exploration result = exploration(options, 1.0);
    EXPECT_EQ(result.breach.fault, acquisition::Fault::none) << flow;
    EXPECT_LT(result.explored.lowest_in, 2.95 - kWindow_in) << flow;
    EXPECT_GT(result.explored.highest_in, 2.95 + kWindow_in) << flow;
    EXPECT_NEAR(result.explored.null_V, -options.valve_null_offset_V, 0.06) << flow;
    EXPECT_LT(result.fastest_new_in_per_s, 0.12) << flow << ": a pulse, over 0.01 in";
    EXPECT_LT(result.time_s, 300.0) << flow;
  }
}

TEST(Explorer, EndsWhereTheRodStandsAtAnEndStopThatAWrongScaleHides) {
  for (const double start_in : {0.4, 2.95, 5.4}) {
    hal::SimOptions options;
    options.initial_displacement_in = start_in;
    const Exploration result = exploration(options, 0.4);
    EXPECT_EQ(result.breach.fault, acquisition::Fault::no_motion) << start_in;
    EXPECT_LT(result.fastest_new_in_per_s, 0.12) << start_in << ": a pulse, over 0.01 in";
  }
}

TEST(Explorer, TurnsSlowlyWhereTheSafeVoltageDrivesTheRodOn) {
  hal::SimOptions options;
  options.valve_rated_flow_L_per_min = 10.0;
  options.valve_null_offset_V = 0.2;  // 0 V extends the rod
  options.valve_dead_band_V = 0.11;
  const Exploration result = exploration(options, 0.62);
  EXPECT_GT(result.explored.highest_in, 2.95 + kWindow_in);
  EXPECT_GT(result.fastest_outwards_in_per_s, 0.02);
  EXPECT_LT(result.fastest_outwards_in_per_s, 0.07) << "0.028 in/s as measured";
}

TEST(Explorer, EndsWhenTheRodMovesTheWrongWay) {
  const Exploration result = exploration({}, -1.0);
  EXPECT_NE(result.breach.fault, acquisition::Fault::none);
  EXPECT_LT(result.time_s, 12.0);
}

}  // namespace
}  // namespace eha::place
