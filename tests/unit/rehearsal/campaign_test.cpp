// SPDX-License-Identifier: GPL-3.0-or-later
// Random experiments on simulated rigs that differ, each rehearsed with the valve that a sheet of that rig would give.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "daemon/rehearsal/rehearsal.hpp"
#include "hal/sim/sim_rig.hpp"
#include "ident/excitation/portable_draw.hpp"

namespace eha {
namespace {

/// Speed of a rig's rod at a constant command, once it has settled [in/s].
double speed_at(hal::SimOptions options, double command_V) {
  options.initial_displacement_in = command_V > 0.0 ? 1.5 : 4.5;
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(options, 0.0);
  hal::AppliedCommand applied;
  hal::RigReading first;
  hal::RigReading last;
  rig->command(command_V, applied);
  rig->set_enable(true);
  for (int k = 0; k <= 3000; ++k) rig->read(static_cast<std::int64_t>(k) * 1'000'000, k <= 1000 ? first : last);
  return (last.displacement_in - first.displacement_in) / 2.0;
}

TEST(RehearsalCampaign, ForetellsTripsOfRandomExperimentsOnPerturbedRigs) {
  ident::PortableDraw draw(11);
  const auto between = [&](double low, double high) { return low + (high - low) * draw.uniform(); };
  int trips = 0;
  int foretold = 0;
  int completed = 0;
  int refused = 0;
  for (int i = 0; i < 200; ++i) {
    config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
    auto& options = std::get<hal::SimOptions>(rig.backend);
    options.valve_null_offset_V = between(-0.4, 0.4);
    options.valve_dead_band_V = between(0.05, 0.4);
    options.rod_mm = between(16.0, 28.0);
    const double null_V = -options.valve_null_offset_V;
    const double band_V = options.valve_dead_band_V;
    // What a valve sheet would write, its errors included.
    rig.limits.following =
        config::Following{.gain_positive_in_per_V_s =
                              0.5 * speed_at(options, null_V + band_V + 2.0) / 2.0 * (1.0 + 0.012 * draw.normal()),
                          .gain_negative_in_per_V_s =
                              -0.5 * speed_at(options, null_V - band_V - 2.0) / 2.0 * (1.0 + 0.012 * draw.normal()),
                          .null_V = null_V + 0.004 * draw.normal(),
                          .dead_band_V = band_V + 0.05 + 0.003 * draw.normal(),
                          .null_uncertainty_V = 0.01,
                          .dead_band_uncertainty_V = 0.01,
                          .gain_uncertainty_percent = 3.0};
    const std::string text = fmt::format(
        "schema = 1\nname = \"r\"\nduration_s = 20.0\n[excitation]\nkind = \"multisine\"\noffset_V = {:.4f}\ntones = "
        "[\n"
        "{{ frequency_Hz = 0.1, amplitude_V = {:.3f}, phase_rad = {:.3f} }},\n"
        "{{ frequency_Hz = 0.5, amplitude_V = {:.3f}, phase_rad = {:.3f} }}]\n[record]\ndiscard_s = 0.0\n",
        null_V + between(-1.6, 1.6), between(0.4, 1.6), between(0.0, 6.28), between(0.4, 1.6), between(0.0, 6.28));
    const config::PreparedExperiment experiment = config::parse_prepared_experiment(text, "r.toml", rig);
    options.initial_displacement_in = between(1.5, 4.5);
    const auto rehearsal = rehearse(experiment, rig, options.initial_displacement_in);
    ASSERT_TRUE(rehearsal.has_value());
    const bool is_refused = rehearsal->chance_of_trip >= kRefusedChanceOfTrip;

    const std::unique_ptr<hal::Rig> plant = hal::open_rig(options, 0.0);
    hal::AppliedCommand applied;
    hal::RigReading reading;
    plant->set_enable(true);
    bool trips_now = false;
    for (Eigen::Index k = 0; k < experiment.table_V.size() && !trips_now; ++k) {
      plant->read(static_cast<std::int64_t>(k) * 1'000'000, reading);
      plant->command(experiment.table_V[k], applied);
      // The stopping distance at the speeds of this valve.
      trips_now = reading.displacement_in > rig.limits.travel_max_in - 0.02 ||
                  reading.displacement_in < rig.limits.travel_min_in + 0.02;
    }
    trips += trips_now ? 1 : 0;
    foretold += trips_now && is_refused ? 1 : 0;
    completed += trips_now ? 0 : 1;
    refused += !trips_now && is_refused ? 1 : 0;
  }
  fmt::print("{} of {} trips foretold, {} of {} others refused\n", foretold, trips, refused, completed);
  EXPECT_GT(trips, 40) << "about a third must trip for the figures to mean anything";
  EXPECT_GE(foretold, 0.95 * trips);
  EXPECT_LE(refused, 0.05 * completed);
}

}  // namespace
}  // namespace eha
