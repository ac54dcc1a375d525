// SPDX-License-Identifier: GPL-3.0-or-later
// A suspend of the machine while `eha` drives the rig itself: the built program on the stand-in card.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/system/driven_rig.hpp"
#include "tests/system/fake_logind.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kDrivenTicks = 300;
constexpr std::uint32_t kRestCode = 32768;  ///< 0 V

class LocalSuspend : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = DrivenRig::obstacle(); !why.empty()) GTEST_SKIP() << why;
  }
  [[nodiscard]] fs::path mark() const { return folder_.path() / "suspended"; }

  /// Starts `eha run --local` and waits until it drives. @param bus  address of the system bus
  [[nodiscard]] std::unique_ptr<Driver> drive(const std::string& bus) {
    folder_.write("rig.toml", DrivenRig::rig_text(std::nullopt));
    folder_.write("long.toml", quiet_experiment_text("long", 60.0));
    std::vector<std::string> environment = rig_.environment();
    for (std::string& variable : environment) {
      const std::string loaded = "LD_PRELOAD=";
      if (variable.starts_with(loaded)) variable.insert(loaded.size(), std::string(EHA_HOST_TRAP_LIBRARY) + ":");
    }
    environment.push_back("EHA_TRAP_SUSPENDED=" + mark().string());
    environment.push_back("DBUS_SYSTEM_BUS_ADDRESS=" + bus);
    auto driver = std::make_unique<Driver>(
        std::vector<std::string>{EHA_PROGRAM, "run", "--local", "--yes", "--rig", "rig.toml", "long.toml"}, environment,
        folder_.path());
    EXPECT_TRUE(rig_.is_driven(kDrivenTicks)) << "not driven";
    return driver;
  }

  TemporaryFolder folder_;
  DrivenRig rig_;
};

TEST_F(LocalSuspend, IsMadeSafeInTheFirstTickAfterIt) {
  const auto driver = drive("unix:path=/no/such/bus");
  const std::uint64_t before = rig_.card().commands;
  std::ofstream(mark()) << "100 s";
  EXPECT_EQ(driver->wait(), static_cast<int>(ExitCode::safety_trip)) << driver->messages();
  EXPECT_FALSE(rig_.card().is_enabled());
  EXPECT_EQ(rig_.card().output_code, kRestCode);
  EXPECT_LT(rig_.card().commands - before, 200U);
  const std::string& said = driver->messages();
  EXPECT_NE(said.find("suspended at "), std::string::npos) << said;
  EXPECT_NE(said.find("the machine was suspended for 100 s"), std::string::npos) << said;
  EXPECT_NE(said.find("a suspend of the machine cannot be delayed during a run"), std::string::npos) << said;
}

TEST_F(LocalSuspend, IsDelayedUntilTheCommandIsRampedOut) {
  if (!FakeLogind::is_possible()) GTEST_SKIP() << "dbus-daemon is not installed";
  FakeLogind logind(folder_.path());
  ASSERT_TRUE(logind.works());
  const auto driver = drive(logind.address());
  ASSERT_TRUE(logind.await_held(true));
  EXPECT_EQ(logind.asked(), "sleep delay");
  logind.announce_sleep();
  EXPECT_TRUE(logind.await_held(false));
  EXPECT_FALSE(rig_.card().is_enabled()) << "the machine may sleep now";
  EXPECT_EQ(driver->wait(), static_cast<int>(ExitCode::interrupted)) << driver->messages();
  EXPECT_NE(driver->messages().find("the machine is about to be suspended: ramping out"), std::string::npos)
      << driver->messages();
}

}  // namespace
}  // namespace eha::test
