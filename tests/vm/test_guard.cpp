// SPDX-License-Identifier: GPL-3.0-or-later
// eha-safe, alone and as a guard, on the stand-in card.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "board.hpp"
#include "core/error.hpp"
#include "daemon/eha-safe/guard_process.hpp"
#include "hal/comedi/comedi_rig.hpp"
#include "hal/snapshot_file.hpp"
#include "process.hpp"

namespace eha::test {
namespace {

constexpr const char* kSnapshot = "/tmp/guard.json";
constexpr const char* kProgram = "/usr/bin/eha-safe";
hal::ComediOptions card() {
  hal::ComediOptions options;
  options.board = "pci1716";
  options.driver = "adv_pci1710";
  options.feedback.subdevice = 0;
  options.command = {.subdevice = 1, .range_min_V = -5.0, .range_max_V = 5.0};
  options.enable = hal::DigitalLine{3, 0, hal::ActiveLevel::high};
  options.scale_in_per_V = 0.6;
  options.calibration_date = "2026-01-15";
  return options;
}

std::unique_ptr<hal::Rig> open_and_drive() {
  auto rig = hal::open_rig(card(), 0.0);
  hal::write_safe_snapshot(rig->safe_snapshot(), kSnapshot);
  hal::AppliedCommand applied;
  EXPECT_EQ(rig->set_enable(true), hal::RigStatus::ok);
  EXPECT_EQ(rig->command(3.0, applied), hal::RigStatus::ok);
  return rig;
}

bool valve_driven() { return read_wire().ao0_uV > 2'900'000; }
bool enabled() { return (read_wire().digital_outputs & kEnableBit) != 0; }
bool driven() { return valve_driven() && enabled(); }

/// Forks a process that drives the rig, under a guard or not, until it is killed; returns once it does.
enum class Guarded { yes, no };
pid_t start_driver(Guarded guarded) {
  int ready[2];
  if (pipe(ready) != 0) return -1;
  const pid_t driver = fork();
  if (driver == 0) {
    try {
      const auto rig = open_and_drive();
      std::optional<GuardProcess> guard;
      if (guarded == Guarded::yes) guard.emplace(kProgram, kSnapshot);
      if (write(ready[1], "!", 1) == 1) {
        for (;;) pause();
      }
    } catch (const Error& error) {
      std::fprintf(stderr, "%s\n", error.what());
    }
    _exit(1);
  }
  close(ready[1]);
  char byte = 0;
  EXPECT_EQ(read(ready[0], &byte, 1), 1);
  close(ready[0]);
  return driver;
}

void end(pid_t driver) {
  ASSERT_EQ(kill(driver, SIGKILL), 0);
  int status = 0;
  ASSERT_EQ(waitpid(driver, &status, 0), driver);
  ASSERT_TRUE(WIFSIGNALED(status));
}

std::int64_t last_change_ns() { return read_wire_changes().back().time_ns; }

TEST(Guard, MakesTheRigSafeWithinHalfASecondOfTheDeathOfItsDriver) {
  const Board board("pci1716_card");
  const pid_t driver = start_driver(Guarded::yes);
  ASSERT_TRUE(driven());
  timespec killed{};
  clock_gettime(CLOCK_MONOTONIC, &killed);
  end(driver);
  ASSERT_TRUE(wait_until(wire_is_safe));
  const std::int64_t killed_ns = std::int64_t{killed.tv_sec} * 1'000'000'000 + killed.tv_nsec;
  EXPECT_LT(last_change_ns() - killed_ns, 500'000'000);
}

TEST(Guard, KillsADriverThatIsStoppedAndMakesTheRigSafeWithinASecond) {
  const Board board("pci1716_card");
  const pid_t driver = start_driver(Guarded::yes);
  ASSERT_TRUE(driven());
  timespec stopped{};
  clock_gettime(CLOCK_MONOTONIC, &stopped);
  ASSERT_EQ(kill(driver, SIGSTOP), 0);
  ASSERT_TRUE(wait_until(wire_is_safe));
  const std::int64_t stopped_ns = std::int64_t{stopped.tv_sec} * 1'000'000'000 + stopped.tv_nsec;
  EXPECT_LT(last_change_ns() - stopped_ns, 1'000'000'000);
  int status = 0;
  ASSERT_EQ(waitpid(driver, &status, 0), driver);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << status;
}

TEST(Guard, LeavesARigAloneThatItIsToldIsSafe) {
  const Board board("pci1716_card");
  auto rig = open_and_drive();
  GuardProcess guard(kProgram, kSnapshot);
  ASSERT_EQ(rig->make_safe(), hal::RigStatus::ok);
  rig.reset();
  const std::size_t before = read_wire_changes().size();
  guard.done();
  EXPECT_EQ(read_wire_changes().size(), before);
}

TEST(EhaSafe, SwitchesOffAtOnceAndWritesTheSafeVoltageAfterTheLock) {
  const Board board("pci1716_card");
  const pid_t driver = start_driver(Guarded::no);
  ASSERT_TRUE(driven());
  Process helper({"eha-safe", kSnapshot});
  EXPECT_TRUE(wait_until([] { return !enabled(); }));
  // Time for attempts, each of which the lock must refuse.
  usleep(200'000);
  EXPECT_TRUE(valve_driven());
  end(driver);
  EXPECT_EQ(helper.wait(), 0) << helper.output();
  EXPECT_TRUE(wire_is_safe());
}

TEST(EhaSafe, IsNotNeededWhereAnEhadIsStartedThoughItCannotStart) {
  const Board board("pci1716_card");
  const std::filesystem::path folder = "/tmp/left";
  std::filesystem::create_directory(folder);
  const pid_t driver = start_driver(Guarded::no);
  std::filesystem::copy_file(kSnapshot, folder / "safe.json");
  end(driver);
  ASSERT_TRUE(driven());
  Process service(
      {"ehad", "--rig", folder / "none.toml", "--state", folder / "state", "--socket", folder / "ehad.sock"});
  EXPECT_NE(service.wait(), 0) << service.output();
  EXPECT_FALSE(enabled());
  EXPECT_FALSE(valve_driven());
  EXPECT_FALSE(std::filesystem::exists(folder / "safe.json"));
}

TEST(EhaSafe, FailsLoudlyWhenTheLockIsNeverReleased) {
  const Board board("pci1716_card");
  const auto rig = open_and_drive();
  Process helper({"eha-safe", kSnapshot});
  EXPECT_EQ(helper.wait(), 69);
  EXPECT_NE(helper.output().find("NOT SAFE"), std::string::npos) << helper.output();
  EXPECT_TRUE(valve_driven());
  EXPECT_FALSE(enabled());
}

TEST(EhaSafe, WritesNothingToAnotherBoard) {
  {
    const Board board("pci1716_card");
    open_and_drive();
  }
  const Board board("comedi_test");
  Process helper({"eha-safe", kSnapshot});
  EXPECT_EQ(helper.wait(), 69);
  EXPECT_NE(helper.output().find("expected the board \"pci1716\", found \"comedi_test\""), std::string::npos)
      << helper.output();
}

}  // namespace
}  // namespace eha::test
