// SPDX-License-Identifier: GPL-3.0-or-later
// Characterisations of rigs without [following] whose sensor's scale is wrong: the rod must not hit an end stop. The
// real tick engine, limits, sources and simulated cylinder.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string>

#include "tests/unit/place/unknown_rig.hpp"

namespace eha::place {
namespace {

TEST(WrongScaleCampaign, NeverHitsAnEndStop) {
  const config::RigConfig rig = unknown_rig();
  const int runs = number_of("EHA_CAMPAIGN_RUNS", 500);
  const int first = number_of("EHA_CAMPAIGN_FIRST", 0);
  const bool says_each = std::getenv("EHA_CAMPAIGN_SAYS") != nullptr;
  std::map<std::string, int> ends;
  int contacts = 0;
  double worst_in_per_s = 0.0;
  for (int run = first; run < first + runs; ++run) {
    const Drawn of_run = drawn(static_cast<unsigned>(run));
    const Measured result = measured(of_run, rig);
    ++ends[result.is_complete ? "completed" : std::string(acquisition::to_text(result.fault))];
    contacts += result.impact_in_per_s > 0.0 ? 1 : 0;
    worst_in_per_s = std::max(worst_in_per_s, result.impact_in_per_s);
    const std::string what = fmt::format(
        "run {}: gain {:.2f} in/(V s), scale x{:.2f} about {:.2f} in, null {:+.2f} V, dead band {:.2f} V, noise {:.4f} "
        "V, from {:.2f} in: {} after {:.1f} s, impact {:.3f} in/s",
        run, of_run.gain_in_per_V_s, of_run.factor, of_run.about_in, -of_run.plant.valve_null_offset_V,
        of_run.plant.valve_dead_band_V, of_run.plant.sensor_noise_V, of_run.plant.initial_displacement_in,
        acquisition::to_text(result.fault), result.at_s, result.impact_in_per_s);
    if (says_each) fmt::print("{}\n", what);
    EXPECT_LE(result.impact_in_per_s, 0.1) << what;
  }
  for (const auto& [end, count] : ends) fmt::print("{}: {}\n", end, count);
  fmt::print("{} runs, {} met an end stop, at {:.3f} in/s at most\n", runs, contacts, worst_in_per_s);
}

}  // namespace
}  // namespace eha::place
