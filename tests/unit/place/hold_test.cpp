// SPDX-License-Identifier: GPL-3.0-or-later
// An experiment in a held rod, on simulated rigs that differ from what the rig file says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "config/prepared_experiment.hpp"
#include "daemon/place/hold_source.hpp"
#include "hal/sim/normal_noise.hpp"
#include "hal/sim/sim_rig.hpp"
#include "tests/unit/place/long_play.hpp"

namespace eha::place {
namespace {

using acquisition::Outcome;
using acquisition::State;

config::PreparedExperiment paper(const config::RigConfig& rig) {
  std::string text = config::load_experiment(EHA_SOURCE_DIR "/config/experiments/paper.toml").text;
  text += "\n[hold]\n";
  return config::parse_prepared_experiment(text, "held.toml", rig);
}

std::span<const double> span_of(const Eigen::VectorXd& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

/// Mean of the displacement over the last 40 s, whole periods of paper.toml's tones.
double mean_of_the_used_part(const LongPlay& play) {
  const std::size_t first = play.first(State::running);
  double sum_in = 0.0;
  for (std::size_t k = 10'000; k < 50'000; ++k) sum_in += play.rows[first + k].displacement_in;
  return sum_in / 40'000.0;
}

TEST(Hold, PredictsAPeriodicMotionWithoutDrift) {
  const config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  const config::PreparedExperiment held = paper(rig);
  ASSERT_EQ(held.predicted_in.size(), held.table_V.size());
  // Tones of whole periods in 20 s: the last 40 s of 50 hold two.
  EXPECT_NEAR(held.predicted_in.tail(40'000).mean(), 0.0, 1e-9);
  for (const Eigen::Index k : {0, 7'000, 19'000}) {
    EXPECT_NEAR(held.predicted_in[k], held.predicted_in[k + 20'000], 1e-6);
  }
  EXPECT_GT(held.predicted_in.maxCoeff() - held.predicted_in.minCoeff(), 1.0) << "the slow tones move it";
}

TEST(Hold, KeepsTheRodInItsStrokeWithoutTakingTheTonesAway) {
  config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  const config::PreparedExperiment held = paper(rig);
  const double gain = config::hold_gains(rig).usual;
  // Null, dead band and rod at the corners of what a rig may have.
  const std::vector<std::array<double, 3>> corners{{0.4, 0.05, 16.0}, {-0.4, 0.4, 28.0}, {0.2, 0.15, 20.0}};
  for (const auto& [null_V, dead_band_V, rod_mm] : corners) {
    auto options = std::get<hal::SimOptions>(rig.backend);
    options.valve_null_offset_V = null_V;
    options.valve_dead_band_V = dead_band_V;
    options.rod_mm = rod_mm;
    LongPlay play;
    play.limits = rig.limits;
    // The valve is not what the file says.
    play.limits.following.reset();
    const std::unique_ptr<hal::Rig> plant = hal::open_rig(options, 0.0);
    StartingSource source(
        PlaceController(play.limits, 0.001, 2.95 + held.predicted_in[0]), play.limits, 0.001,
        std::make_unique<HoldSource>(span_of(held.table_V), span_of(held.predicted_in), 1U, config::HoldLaw{gain, 1.0},
                                     LoopMonitor(loop_bounds(play.limits), 0.001)));
    play.play_on(*plant, source);
    EXPECT_EQ(play.report.outcome, Outcome::completed) << null_V << " V: " << to_text(play.report.fault.fault);
    if (play.report.outcome != Outcome::completed) continue;
    EXPECT_NEAR(mean_of_the_used_part(play), 2.95, 0.1) << null_V << " V, " << dead_band_V << " V";
    const std::size_t first = play.first(State::running);
    double lowest_in = 10.0;
    double highest_in = 0.0;
    for (std::size_t k = 10'000; k < 50'000; ++k) {
      lowest_in = std::min(lowest_in, play.rows[first + k].displacement_in);
      highest_in = std::max(highest_in, play.rows[first + k].displacement_in);
    }
    EXPECT_GT(highest_in - lowest_in, 1.0);
  }
}

TEST(Hold, AddsNoMoreThanItsBoundAndNothingInItsMiddle) {
  const std::vector<double> table_V{0.5, 0.5, 0.5};
  const std::vector<double> predicted_in{0.0, 0.1, 0.2};
  HoldSource source(table_V, predicted_in, 1, {5.0, 1.0}, LoopMonitor({}, 0.001));
  hal::RigReading reading;
  reading.displacement_in = 3.0;
  EXPECT_DOUBLE_EQ(source.voltage_V(0, reading), 0.5);
  EXPECT_DOUBLE_EQ(source.voltage_V(1, reading), 0.5 + 5.0 * 0.1);
  reading.displacement_in = -9.0;
  EXPECT_DOUBLE_EQ(source.voltage_V(2, reading), 1.5);
}

}  // namespace
}  // namespace eha::place
