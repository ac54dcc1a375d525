// SPDX-License-Identifier: GPL-3.0-or-later
// A driving backend that is merely added to the list gets every safety measure.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include "config/rig_config.hpp"
#include "core/error.hpp"
#include "daemon/rig/confirmation.hpp"
#include "daemon/rig/owned_rig.hpp"
#include "daemon/rig/trusted_file.hpp"
#include "hal/backends/backend.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::hal {
namespace {

/// A rig with a snapshot that eha-safe does not support.
class MadeUpRig final : public Rig {
 public:
  [[nodiscard]] const RigCapabilities& capabilities() const noexcept override { return capabilities_; }
  RigStatus read(std::int64_t, RigReading&) noexcept override { return RigStatus::ok; }
  RigStatus command(double, AppliedCommand&) noexcept override { return RigStatus::ok; }
  RigStatus set_enable(bool) noexcept override { return RigStatus::ok; }
  RigStatus make_safe() noexcept override { return RigStatus::ok; }
  [[nodiscard]] std::string safe_snapshot() const override { return R"({"backend": "made_up"})"; }

 private:
  RigCapabilities capabilities_;
};

}  // namespace

std::vector<OptionIssue> check(const MadeUpOptions&) { return {}; }
std::unique_ptr<Rig> open_rig(const MadeUpOptions&, double) { return std::make_unique<MadeUpRig>(); }
SafeAction MadeUpOptions::safe_action(std::string_view, std::string_view) {
  return {.device = "/dev/made-up", .make_safe = [](std::chrono::milliseconds) { return "made safe"; }};
}

}  // namespace eha::hal

namespace eha {
namespace {

std::string rig_text(const std::string& backend, const std::string& keys) {
  return "schema = 1\nname = \"press\"\nbackend = \"" + backend + "\"\n" + R"([limits]
command_min_V = -5.0
command_max_V = 5.0
slew_V_per_s = 250.0
safe_V = 0.0
travel_min_in = 0.5
travel_max_in = 5.5
stopping_deceleration_in_per_s2 = 200.0
velocity_limit_in_per_s = 10.0
frozen_sensor_s = 0.0
[)" + backend +
         "]\n" + keys;
}

const std::string kMadeUp = rig_text("made_up", "port = \"/dev/press\"\n");
const std::string kSimulated = rig_text("sim", "");

std::string message_of(const auto& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(MadeUpBackend, IsReadFromARigFileThroughItsOwnKeys) {
  const config::RigConfig rig = config::parse_rig(kMadeUp, "r.toml");
  EXPECT_EQ(hal::name_of(rig.backend), "made_up");
  EXPECT_TRUE(hal::moves_machine(rig.backend));
  EXPECT_FALSE(hal::has_virtual_clock(rig.backend));
  EXPECT_EQ(message_of([] { (void)config::parse_rig(kMadeUp + "gain_V = -1.0\nspeed = 1\n[sim]\n", "r.toml"); }),
            "r.toml:16:10: made_up.gain_V: expected a number above 0, got -1\n"
            "r.toml:17:1: made_up.speed: expected a known key (one of port, gain_V), got an unknown one\n"
            "r.toml:18:1: sim: expected no such key (backend = \"made_up\"), got a table");
}

TEST(MadeUpBackend, NeedsARigFileThatOnlyRootCanWrite) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "rig.toml";
  std::ofstream(path) << kMadeUp;
  config::RigConfig rig = config::load_rig(path);
  ASSERT_EQ(chmod(path.c_str(), 0666), 0);
  EXPECT_THROW(require_trusted_rig_file(rig), PermissionError);
  std::ofstream(path) << kSimulated;
  rig = config::load_rig(path);
  EXPECT_NO_THROW(require_trusted_rig_file(rig)) << "a simulated rig moves nothing";
}

TEST(MadeUpBackend, IsConfirmedBeforeItMoves) {
  config::ExperimentConfig experiment;
  experiment.name = "paper";
  experiment.duration_s = 50.0;
  EXPECT_EQ(confirmation_text(config::parse_rig(kMadeUp, "r.toml"), experiment),
            "This moves the actuator on /dev/press (made up): \"paper\", 50 s, within -5..5 V.");
  EXPECT_EQ(confirmation_text(config::parse_rig(kSimulated, "r.toml"), experiment), std::nullopt);
}

TEST(MadeUpBackend, IsNotDrivenWithoutAGuard) {
  // The built guard does not have this backend, so it does not start.
  const std::string message = message_of([] { const OwnedRig rig(config::parse_rig(kMadeUp, "r.toml")); });
  EXPECT_NE(message.find("the guard of the rig does not start"), std::string::npos) << message;
  EXPECT_NO_THROW(OwnedRig(config::parse_rig(kSimulated, "r.toml")));
}

TEST(MadeUpBackend, IsMadeSafeFromItsOwnSnapshot) {
  const hal::SafeAction action = hal::safe_action(R"({"backend": "made_up"})", "safe.json");
  EXPECT_EQ(action.device, "/dev/made-up");
  EXPECT_EQ(action.make_safe(std::chrono::milliseconds(0)), "made safe");
}

}  // namespace
}  // namespace eha
