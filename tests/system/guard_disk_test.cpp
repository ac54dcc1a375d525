// SPDX-License-Identifier: GPL-3.0-or-later
// A driver that is killed while its disk hangs: the built programs on the stand-in card, their runs on a file system
// that is frozen.
#include <gtest/gtest.h>
#include <time.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/system/daemon.hpp"
#include "tests/system/driven_rig.hpp"
#include "tests/system/own_mounts.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using std::chrono::steady_clock;

constexpr std::uint32_t kSafeCode = 32768;  ///< 0 V
constexpr std::chrono::seconds kSoon(1);
constexpr std::int64_t kOff_ns = 200'000'000;  ///< longest time to the hydraulics off, with stall_limit_s = 0.15

std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// Waits until a condition holds. @returns whether it came to that
bool holds(const std::function<bool()>& condition, steady_clock::duration patience = kGenerous) {
  const auto deadline = steady_clock::now() + patience;
  while (!condition()) {
    if (steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

/// A process that does not run until resume().
class Stopped {
 public:
  explicit Stopped(pid_t process) : process_(process) { kill(process_, SIGSTOP); }
  Stopped(const Stopped&) = delete;
  Stopped& operator=(const Stopped&) = delete;
  ~Stopped() { resume(); }
  void resume() const { kill(process_, SIGCONT); }

 private:
  pid_t process_;
};

class GuardOfAHangingDisk : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = DrivenRig::obstacle(); !why.empty()) GTEST_SKIP() << why;
    if (!has_own_mounts()) GTEST_SKIP() << "this user may not mount";
    fs::create_directory(runs());
    if (!mount_disk(folder_.path() / "disk", runs())) GTEST_SKIP() << "no ext4 on a loop device here";
  }
  [[nodiscard]] fs::path runs() const { return folder_.path() / "runs"; }

  /// Starts `eha run --local` with a voltage other than the safe one, and waits until that stands at the output, after
  /// pressure_delay_s.
  [[nodiscard]] std::unique_ptr<Driver> drive() {
    folder_.write("rig.toml", DrivenRig::rig_text(std::nullopt));
    std::string experiment = quiet_experiment_text("long", 60.0);
    const std::string offset = "offset_V = -0.2";
    experiment.replace(experiment.find(offset), offset.size(), "offset_V = 0.25");
    folder_.write("long.toml", experiment);
    auto driver = std::make_unique<Driver>(std::vector<std::string>{EHA_PROGRAM, "run", "--local", "--yes", "--rig",
                                                                    "rig.toml", "--output", "runs/kept", "long.toml"},
                                           rig_.environment(), folder_.path());
    if (!rig_.is_driven(300) || !holds([&] { return rig_.card().output_code != kSafeCode; })) {
      throw std::runtime_error("it is not driven");
    }
    return driver;
  }

  /// The driver's guard has made the rig safe and saved the rows of the `made` ticks.
  void expect_end(Driver& driver, std::uint64_t made) const {
    EXPECT_EQ(driver.wait(), 128 + SIGKILL);
    EXPECT_EQ(rig_.card().output_code, kSafeCode);
    EXPECT_NE(driver.messages().find("rows are saved"), std::string::npos) << driver.messages();
    EXPECT_NE(driver.messages().find("hydraulics off"), std::string::npos) << driver.messages();
    EXPECT_GE(ticks_recorded(only_run(runs() / "kept")) + 1, made);
  }

  TemporaryFolder folder_;
  const Mounted disk_{runs()};
  DrivenRig rig_;
};

TEST_F(GuardOfAHangingDisk, WritesTheSafeVoltageBeforeTheRowsAreSavedAndSavesThemOnceTheDiskAnswers) {
  const auto driver = drive();
  // The guard does not look while the driver dies and the disk begins to hang.
  const pid_t guard = child_of(driver->pid());
  const Stopped stopped(guard);
  driver->end(SIGKILL);
  const std::uint64_t made = rig_.card().commands;
  ASSERT_NE(rig_.card().output_code, kSafeCode);
  os::FileDescriptor output = rig_.take_output();
  Frozen frozen(runs());
  stopped.resume();

  EXPECT_TRUE(holds([&] { return !rig_.card().is_enabled(); }));
  ASSERT_TRUE(holds([&] { return waits_for_disk(guard); })) << "nobody saves the rows";
  EXPECT_NE(rig_.card().output_code, kSafeCode) << "the output was free too early for this test";
  output.close();
  EXPECT_TRUE(holds([&] { return rig_.card().output_code == kSafeCode; }, kSoon)) << "it waits for the disk";
  EXPECT_TRUE(waits_for_disk(guard)) << "the disk answered too early for this test";

  frozen.thaw();
  expect_end(*driver, made);
}

TEST_F(GuardOfAHangingDisk, SwitchesTheHydraulicsOffThoughTheDriverCannotDieBeforeTheDiskAnswers) {
  const auto driver = drive();
  Frozen frozen(runs());
  ASSERT_TRUE(holds([&] { return waits_for_disk(driver->pid()); })) << "its writer does not write";
  const std::int64_t killed_ns = now_ns();
  driver->send(SIGKILL);
  EXPECT_TRUE(holds([&] { return !rig_.card().is_enabled(); }, kSoon));
  const std::int64_t off_ns = rig_.card().disabled_ns - killed_ns;
  std::printf("hydraulics off after %.1f ms\n", static_cast<double>(off_ns) * 1e-6);
  EXPECT_LT(off_ns, kOff_ns);
  EXPECT_TRUE(waits_for_disk(driver->pid())) << "it could die";
  // Its output is its own as long as it lives.
  EXPECT_NE(rig_.card().output_code, kSafeCode);

  frozen.thaw();
  expect_end(*driver, rig_.card().commands);
}

}  // namespace
}  // namespace eha::test
