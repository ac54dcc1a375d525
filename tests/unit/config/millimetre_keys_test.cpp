// SPDX-License-Identifier: GPL-3.0-or-later
// Lengths of configuration files in millimetres: the configuration holds inches.
#include <gtest/gtest.h>

#include <string>

#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"
#include "core/error.hpp"
#include "core/millimetre_key.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::config {
namespace {

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

std::string sim_text() { return load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml").text; }

std::string refusal_of(const std::string& text) {
  try {
    static_cast<void>(parse_rig(text, "rig.toml"));
    return "";
  } catch (const ConfigError& error) {
    return error.what();
  }
}

TEST(MillimetreKey, IsThatOfAKeyWithInches) {
  EXPECT_EQ(millimetre_key("travel_min_in")->name, "travel_min_mm");
  EXPECT_DOUBLE_EQ(millimetre_key("velocity_limit_in_per_s")->factor, 1.0 / 25.4);
  EXPECT_EQ(millimetre_key("gain_V_per_in")->name, "gain_V_per_mm");
  EXPECT_DOUBLE_EQ(millimetre_key("gain_V_per_in")->factor, 25.4);
  for (const char* other : {"bore_mm", "min_V", "in_V", "index", "null_V", "point_inside"}) {
    EXPECT_FALSE(millimetre_key(other)) << other;
  }
}

TEST(MillimetreKeys, GiveTheSameRigAsInches) {
  std::string text = sim_text();
  text = replaced(text, "travel_min_in = 0.15 ", "travel_min_mm = 3.81 ");
  text = replaced(text, "velocity_limit_in_per_s = 8.0 ", "velocity_limit_mm_per_s = 203.2 ");
  text = replaced(text, "gain_positive_in_per_V_s = 0.074", "gain_positive_mm_per_V_s = 1.8796");
  text = replaced(text, "initial_displacement_in = 2.95", "initial_displacement_mm = 74.93");
  const RigConfig rig = parse_rig(text, "rig.toml");
  EXPECT_NEAR(rig.limits.travel_min_in, 0.15, 1e-12);
  EXPECT_NEAR(rig.limits.velocity_limit_in_per_s, 8.0, 1e-12);
  EXPECT_NEAR(rig.limits.following->gain_positive_in_per_V_s, 0.074, 1e-12);
}

TEST(MillimetreKeys, AreRefusedBesideInchesAndBeyondTheRangeInTheirOwnUnit) {
  const std::string both =
      refusal_of(replaced(sim_text(), "travel_min_in = 0.15 ", "travel_min_mm = 3.81\ntravel_min_in = 0.15 "));
  EXPECT_NE(both.find("limits.travel_min_mm: the same as limits.travel_min_in; leave out one of the two"),
            std::string::npos)
      << both;
  const std::string negative =
      refusal_of(replaced(sim_text(), "velocity_limit_in_per_s = 8.0 ", "velocity_limit_mm_per_s = -3.0 "));
  EXPECT_NE(negative.find("limits.velocity_limit_mm_per_s: expected"), std::string::npos) << negative;
  EXPECT_NE(refusal_of(replaced(sim_text(), "travel_min_in = 0.15 ", "travel_min_cm = 0.4 ")).find("unknown"),
            std::string::npos);
}

TEST(MillimetreKeys, StandInExperimentsToo) {
  const auto text = [](const char* start) {
    return std::string(
               "schema = 1\nname = \"e\"\nduration_s = 10.0\n[excitation]\nkind = \"sine\"\n"
               "tones = [ { frequency_Hz = 0.2, amplitude_V = 1.0 } ]\n[record]\ndiscard_s = 0.0\n[start]\n") +
           start;
  };
  EXPECT_NEAR(parse_experiment(text("displacement_mm = 75.0\n"), "e.toml").played()->start->displacement_in,
              75.0 / 25.4, 1e-12);
  EXPECT_NEAR(parse_experiment(text("displacement_in = 3.0\n"), "e.toml").played()->start->displacement_in, 3.0, 1e-12);
}

}  // namespace
}  // namespace eha::config
