// SPDX-License-Identifier: GPL-3.0-or-later
// A driven rig whose loop stands still, whose card does not answer or whose driver is killed: the built programs on the
// stand-in card, watched from this process.
#include <gtest/gtest.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/priorities.hpp"
#include "daemon/record/run_folder.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/driven_rig.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

std::int64_t monotonic_ns() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Value of a setting in the service's unit.
std::string unit_setting(const std::string& name) {
  const std::string unit = content_of(source_file("systemd/ehad.service"));
  const std::size_t at = unit.find("\n" + name + "=");
  if (at == std::string::npos) throw std::runtime_error("the unit has no " + name);
  const std::size_t begin = at + name.size() + 2;
  return unit.substr(begin, unit.find('\n', begin) - begin);
}

constexpr std::int64_t kOff_ns = 200'000'000;  ///< longest time to the hydraulics off, with stall_limit_s = 0.15
constexpr std::uint32_t kSafeCode = 32768;     ///< 0 V

class Guard : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = DrivenRig::obstacle(); !why.empty()) GTEST_SKIP() << why;
  }

  /// Starts `eha run --local`, under the service's limit on real-time processor time, and waits until it has driven for
  /// 0.3 s.
  [[nodiscard]] std::unique_ptr<Driver> drive(std::optional<int> cpu) {
    folder_.write("rig.toml", DrivenRig::rig_text(cpu));
    folder_.write("long.toml", quiet_experiment_text("long", 60.0));
    auto driver = std::make_unique<Driver>(
        std::vector<std::string>{"/usr/bin/prlimit", "--rttime=" + unit_setting("LimitRTTIME"), EHA_PROGRAM, "run",
                                 "--local", "--yes", "--rig", "rig.toml", "long.toml"},
        rig_.environment(), folder_.path());
    if (!rig_.is_driven(300)) {
      driver->send(SIGKILL);
      driver->wait();
      throw std::runtime_error("it is not driven: " + driver->messages());
    }
    return driver;
  }
  [[nodiscard]] fs::path run() const { return only_run(folder_.path() / "runs"); }
  [[nodiscard]] Json manifest() const { return Json::parse(content_of(run() / "run.json")); }

  TemporaryFolder folder_;
  DrivenRig rig_;
};

/// Processors that the hogs take.
class GuardOfAStarvedLoop : public Guard, public ::testing::WithParamInterface<std::vector<int>> {};

TEST_P(GuardOfAStarvedLoop, SwitchesTheHydraulicsOffAndTheRecordIsSaved) {
  if (sysconf(_SC_NPROCESSORS_ONLN) < 2) GTEST_SKIP() << "needs two processors";
  const auto driver = drive(1);
  Hogs hogs(GetParam(), 700ms);
  const std::int64_t begun_ns = hogs.begun_ns();
  const int code = driver->wait();
  EXPECT_FALSE(rig_.card().is_enabled());
  const std::int64_t off_ns = rig_.card().disabled_ns - begun_ns;
  RecordProperty("off_us", static_cast<int>(off_ns / 1000));
  std::printf("hydraulics off after %.1f ms\n", static_cast<double>(off_ns) * 1e-6);
  EXPECT_LT(off_ns, kOff_ns);
  EXPECT_EQ(rig_.card().output_code, kSafeCode);
  EXPECT_EQ(code, 11) << driver->messages();
  EXPECT_EQ(manifest().at("outcome"), "faulted");
  EXPECT_EQ(manifest().at("report").at("fault").at("cause"), "loop_stalled");
  EXPECT_TRUE(fs::exists(run() / record::kRawFile));
  EXPECT_GE(ticks_recorded(run()), rig_.card().commands);
}

INSTANTIATE_TEST_SUITE_P(OnItsProcessorAndOnAll, GuardOfAStarvedLoop,
                         ::testing::Values(std::vector<int>{1}, std::vector<int>{0, 1}));

TEST(UnitFile, GrantsTheGuardItsPriorityAndSparesIt) {
  EXPECT_EQ(unit_setting("LimitRTPRIO"), std::to_string(kGuardPriority));
  EXPECT_LT(std::stoi(unit_setting("OOMScoreAdjust")), 0);
  EXPECT_EQ(unit_setting("KillMode"), "mixed");
}

TEST_F(Guard, SwitchesTheHydraulicsOffWithinOneCallOfAnOutputThatTimesOut) {
  const auto driver = drive(std::nullopt);
  rig_.card().output_stall_ms = 1000;
  // A few more calls: each takes its second of the limit on real-time processor time.
  std::this_thread::sleep_for(5s);
  rig_.card().output_stall_ms = 0;
  const int code = driver->wait();
  EXPECT_FALSE(rig_.card().is_enabled());
  const std::int64_t off_ns = rig_.card().disabled_ns - rig_.card().stall_begun_ns;
  std::printf("hydraulics off after %.1f ms\n", static_cast<double>(off_ns) * 1e-6);
  EXPECT_LT(off_ns, 1'100'000'000);
  EXPECT_EQ(code, 69) << driver->messages();
  EXPECT_EQ(manifest().at("outcome"), "faulted");
  EXPECT_TRUE(fs::exists(run() / record::kRawFile));
}

TEST_F(Guard, EndsADriverWhoseLoopNeverComesBackAndSavesItsRows) {
  const auto driver = drive(std::nullopt);
  const pid_t loop = thread_named(driver->pid(), "eha-loop");
  if (ptrace(PTRACE_SEIZE, loop, nullptr, nullptr) != 0) GTEST_SKIP() << "this user may not trace its own children";
  ptrace(PTRACE_INTERRUPT, loop, nullptr, nullptr);
  int status = 0;
  waitpid(loop, &status, __WALL);
  // The thread has ended by the guard's SIGKILL when this returns.
  waitpid(loop, &status, __WALL);
  EXPECT_EQ(driver->wait(), 128 + SIGKILL);
  EXPECT_NE(driver->messages().find("stood still and has been killed"), std::string::npos) << driver->messages();
  EXPECT_FALSE(rig_.card().is_enabled());
  EXPECT_EQ(rig_.card().output_code, kSafeCode);
  EXPECT_GE(ticks_recorded(run()) + 1, rig_.card().commands);
}

TEST_F(Guard, SavesTheRowsOfADriverThatIsKilledAndRecoveryReadsThem) {
  const auto driver = drive(std::nullopt);
  driver->send(SIGKILL);
  EXPECT_EQ(driver->wait(), 128 + SIGKILL);
  EXPECT_FALSE(rig_.card().is_enabled());
  EXPECT_EQ(rig_.card().output_code, kSafeCode);
  EXPECT_GE(ticks_recorded(run()) + 1, rig_.card().commands);
  const Ended recovered = run_eha({"runs", "recover", run().string()}, folder_.path());
  EXPECT_EQ(recovered.code, 0) << recovered.err;
  const Json recovery = Json::parse(content_of(run() / "run.json")).at("recovery");
  EXPECT_GE(recovery.at("rows").get<std::uint64_t>() + 1, rig_.card().commands);
  EXPECT_EQ(recovery.at("torn_bytes"), 0);
}

TEST_F(Guard, NeedsNoDeviceNodeToSwitchTheHydraulicsOff) {
  for (const int error : {ENOENT, EMFILE, EBUSY}) {
    rig_.reset();
    fs::remove_all(folder_.path() / "runs");
    const auto driver = drive(std::nullopt);
    rig_.card().open_error = error;
    const std::int64_t killed_ns = monotonic_ns();
    driver->send(SIGKILL);
    EXPECT_EQ(driver->wait(), 128 + SIGKILL);
    EXPECT_FALSE(rig_.card().is_enabled()) << error << driver->messages();
    EXPECT_EQ(rig_.card().output_code, kSafeCode) << error;
    const std::int64_t off_ns = rig_.card().disabled_ns - killed_ns;
    std::printf("errno %d: hydraulics off after %.1f ms\n", error, static_cast<double>(off_ns) * 1e-6);
    EXPECT_LT(off_ns, kOff_ns) << error;
  }
}

TEST_F(Guard, OpensACardAgainThatWasRemovedForHalfASecond) {
  const auto driver = drive(std::nullopt);
  // The driver is halted, so that it does not notice and the guard has to act.
  driver->send(SIGSTOP);
  rig_.card().open_error = ENOENT;
  ++rig_.card().removals;
  std::this_thread::sleep_for(500ms);
  rig_.card().open_error = 0;
  const std::int64_t back_ns = monotonic_ns();
  EXPECT_EQ(driver->wait(), 128 + SIGKILL);
  EXPECT_FALSE(rig_.card().is_enabled()) << driver->messages();
  EXPECT_EQ(rig_.card().output_code, kSafeCode);
  EXPECT_LT(rig_.card().disabled_ns - back_ns, kOff_ns);
}

}  // namespace
}  // namespace eha::test
