// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/narrower_limits.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha {
namespace {

using Sentences = std::vector<std::string>;

const config::RigConfig& in_force() {
  static const config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  return rig;
}

TEST(NarrowerLimits, AreNoneInTheSameFileAndInAWiderOne) {
  config::RigConfig wider = in_force();
  EXPECT_EQ(narrower_limits(in_force(), wider), Sentences{});
  wider.limits.travel_min_in -= 0.1;
  wider.limits.travel_max_in += 0.1;
  wider.limits.command_min_V -= 1.0;
  wider.limits.slew_V_per_s *= 2.0;
  EXPECT_EQ(narrower_limits(in_force(), wider), Sentences{});
}

TEST(NarrowerLimits, AreNamedWithBothValuesInTheUnitOfTheRig) {
  config::RigConfig edited = in_force();
  edited.limits.travel_min_in = 0.5;
  edited.limits.travel_max_in = 5.0;
  edited.limits.command_min_V = -4.0;
  edited.limits.command_max_V = 4.5;
  edited.limits.velocity_limit_in_per_s = 4.0;
  edited.limits.slew_V_per_s = 10.0;
  EXPECT_EQ(narrower_limits(in_force(), edited),
            (Sentences{"travel_min 0.5 in (0.15 in in force)", "travel_max 5 in (5.75 in in force)",
                       "command_min -4 V (-5 V in force)", "command_max 4.5 V (5 V in force)",
                       "velocity_limit 4 in/s (8 in/s in force)", "slew 10 V/s (20 V/s in force)"}));
  config::RigConfig metric = in_force();
  metric.units = "mm";
  edited = metric;
  edited.limits.travel_max_in = 5.0;
  EXPECT_EQ(narrower_limits(metric, edited), Sentences{"travel_max 127 mm (146.05 mm in force)"});
}

TEST(NarrowerLimits, AreThoseOfAnotherCalibration) {
  config::RigConfig edited = config::load_rig(EHA_SOURCE_DIR "/config/rigs/pci1716.toml");
  const config::RigConfig now = edited;
  auto& card = std::get<hal::ComediOptions>(edited.backend);
  card.offset_in += 0.01;
  EXPECT_EQ(narrower_limits(now, edited), Sentences{}) << "within the tolerance of a ruler";
  card.offset_in += 0.54;
  EXPECT_EQ(narrower_limits(now, edited), Sentences{"a calibration by which the rod stands up to 0.55 in elsewhere"});
  card = std::get<hal::ComediOptions>(now.backend);
  card.scale_in_per_V *= 1.1;
  EXPECT_EQ(narrower_limits(now, edited), Sentences{"a calibration by which the rod stands up to 0.28 in elsewhere"});
}

TEST(NarrowerLimits, OfTheFileOnTheDiskAreRefused) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "rig.toml";
  std::string text = in_force().text;
  const auto write = [&](const std::string& content) { static_cast<void>(folder.write("rig.toml", content)); };
  write(text);
  EXPECT_NO_THROW(require_no_narrower_limits(in_force(), file));
  write("half of a fi");
  EXPECT_THROW(require_no_narrower_limits(in_force(), file), ConfigError) << "nobody can tell what it means";
  EXPECT_TRUE(std::filesystem::remove(file));
  EXPECT_THROW(require_no_narrower_limits(in_force(), file), ConfigError) << "gone, as while it is edited elsewhere";
  const std::string wide = "travel_max_in = 5.75";
  write(text.replace(text.find(wide), wide.size(), "travel_max_in = 5.0"));
  EXPECT_THROW(require_no_narrower_limits(in_force(), file), ConfigError);
}

}  // namespace
}  // namespace eha
