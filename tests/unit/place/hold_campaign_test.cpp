// SPDX-License-Identifier: GPL-3.0-or-later
// paper.toml's tones, held, on twenty rigs that are not what their rig file says.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <string>

#include "config/prepared_experiment.hpp"
#include "daemon/place/hold_source.hpp"
#include "hal/sim/sim_rig.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "tests/unit/place/long_play.hpp"

namespace eha::place {
namespace {

std::span<const double> span_of(const Eigen::VectorXd& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

TEST(HoldCampaign, KeepsTwentyPerturbedRigsInMidStroke) {
  const config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  const std::string text = config::load_experiment(EHA_SOURCE_DIR "/config/experiments/paper.toml").text + "\n[hold]\n";
  const config::PreparedExperiment held = config::parse_prepared_experiment(text, "held.toml", rig);
  ident::PortableDraw draw(5);
  const auto between = [&](double low, double high) { return low + (high - low) * draw.uniform(); };
  double greatest_in = 0.0;
  for (int i = 0; i < 20; ++i) {
    auto options = std::get<hal::SimOptions>(rig.backend);
    options.valve_null_offset_V = between(-0.4, 0.4);
    options.valve_dead_band_V = between(0.05, 0.4);
    options.rod_mm = between(16.0, 28.0);
    LongPlay play;
    play.limits = rig.limits;
    // The file's numbers serve the loop only: the following check has a commissioned rig's own.
    play.limits.following.reset();
    const std::unique_ptr<hal::Rig> plant = hal::open_rig(options, 0.0);
    StartingSource source(PlaceController(play.limits, 0.001, 2.95 + held.predicted_in[0]), play.limits, 0.001,
                          std::make_unique<HoldSource>(span_of(held.table_V), span_of(held.predicted_in), 1U,
                                                       config::HoldLaw{config::hold_gains(rig).usual, 1.0},
                                                       LoopMonitor(loop_bounds(play.limits), 0.001)));
    play.play_on(*plant, source);
    ASSERT_EQ(play.report.outcome, acquisition::Outcome::completed)
        << "rig " << i << ": " << to_text(play.report.fault.fault);
    const std::size_t first = play.first(acquisition::State::running);
    double sum_in = 0.0;
    for (std::size_t k = 10'000; k < 50'000; ++k) sum_in += play.rows[first + k].displacement_in;
    const double off_in = sum_in / 40'000.0 - 2.95;
    greatest_in = std::max(greatest_in, std::abs(off_in));
    EXPECT_LT(std::abs(off_in), 0.1) << "rig " << i << ": null " << -options.valve_null_offset_V << " V, dead band "
                                     << options.valve_dead_band_V << " V, rod " << options.rod_mm << " mm";
  }
  fmt::print("mean position at most {:.3f} in from the middle\n", greatest_in);
}

}  // namespace
}  // namespace eha::place
