// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/backends/backend.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "core/error.hpp"
#include "hal/comedi/safe_snapshot.hpp"

namespace eha::hal {
namespace {

TEST(Backend, SaysWhatItDoesNotOnlyWhatItIsCalled) {
  const Backend sim = SimOptions();
  EXPECT_EQ(name_of(sim), "sim");
  EXPECT_FALSE(moves_machine(sim));
  EXPECT_TRUE(has_virtual_clock(sim));
  const Backend card = ComediOptions();
  EXPECT_EQ(name_of(card), "comedi");
  EXPECT_TRUE(moves_machine(card));
  EXPECT_FALSE(has_virtual_clock(card));
}

TEST(Backend, KnowsItsSeedAndItsFirstPositionWhereItHasThem) {
  SimOptions options;
  options.seed = 7;
  options.initial_displacement_in = 1.5;
  EXPECT_EQ(seed_of(options), 7U);
  EXPECT_EQ(initial_displacement_in(options), 1.5);
  EXPECT_EQ(seed_of(ComediOptions()), std::nullopt);
  EXPECT_EQ(initial_displacement_in(ComediOptions()), std::nullopt);
}

TEST(Backend, OpensTheRigThatTheOptionsAreOf) {
  const auto rig = open(SimOptions(), 0.0);
  EXPECT_EQ(rig->capabilities().backend, "sim");
  EXPECT_FALSE(rig->capabilities().moves_machine);
  EXPECT_TRUE(rig->capabilities().has_virtual_clock);
  EXPECT_EQ(rig->safe_snapshot(), "");
}

TEST(SafeAction, IsThatOfTheSnapshotsBackend) {
  SafeSnapshot snapshot;
  snapshot.device = "/dev/no-such-card";
  nlohmann::json json = nlohmann::json::parse(to_text(snapshot));
  EXPECT_EQ(safe_action(json.dump(), "safe.json").device, "/dev/no-such-card");
  EXPECT_THROW((void)safe_action(json.dump(), "safe.json").make_safe(std::chrono::milliseconds(0)), DeviceError);
  json.erase("backend");
  EXPECT_EQ(safe_action(json.dump(), "safe.json").device, "/dev/no-such-card") << "written before backends were named";
  for (const char* name : {"sim", "teapot"}) {
    json["backend"] = name;
    EXPECT_THROW((void)safe_action(json.dump(), "safe.json"), ConfigError) << name;
  }
  for (const char* text : {"", "null", "[1]", "{"}) {
    EXPECT_THROW((void)safe_action(text, "safe.json"), ConfigError) << text;
  }
}

}  // namespace
}  // namespace eha::hal
