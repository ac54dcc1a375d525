// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/machine_checks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <stdexcept>

#include "tests/unit/temporary_folder.hpp"

namespace eha::doctor {
namespace {

/// A machine without fault, its loop on an isolated CPU.
Machine sound_machine() {
  Machine machine;
  machine.kernel = {.release = "6.1.0-25-rt-amd64", .version = "#1 SMP PREEMPT_RT Debian", .preempt_rt = true};
  machine.files = {.governors = {"performance"},
                   .online_cpus = {0, 1},
                   .isolated_cpus = {1},
                   .idle_driver = "intel_idle",
                   .clock_source = "tsc",
                   .clock_sources = {"tsc", "hpet"}};
  machine.privileges = {.is_root = false,
                        .fifo_error = 0,
                        .rtprio_limit = 95,
                        .memlock_limit_bytes = Privileges::kUnlimited,
                        .dma_latency_error = 0};
  return machine;
}

config::RealtimeOptions on_cpu_1() {
  config::RealtimeOptions options;
  options.cpu = 1;
  return options;
}

Check named(const std::vector<Check>& checks, const std::string& name) {
  const auto found = std::find_if(checks.begin(), checks.end(), [&](const Check& check) { return check.name == name; });
  if (found == checks.end()) throw std::logic_error("no check " + name);
  return *found;
}

/// Every check that is not ok has a remedy, every failure a code.
void expect_complete(const std::vector<Check>& checks) {
  for (const Check& check : checks) {
    EXPECT_FALSE(check.found.empty()) << check.name;
    EXPECT_EQ(check.remedy.empty(), check.level == Level::ok) << check.name;
    EXPECT_EQ(check.code != ExitCode::ok, check.level == Level::fail) << check.name;
  }
}

TEST(MachineChecks, PassASoundMachine) {
  const std::vector<Check> checks = check_machine(sound_machine(), on_cpu_1(), Stakes::machine);
  for (const Check& check : checks) EXPECT_EQ(check.level, Level::ok) << check.name << ": " << check.found;
  EXPECT_EQ(exit_code(checks), ExitCode::ok);
  expect_complete(checks);
}

/// What a remedy does that is copied into a shell, where a sudo that only names its command stands for the real one.
std::string printed_by(const std::string& remedy) {
  const test::TemporaryFolder folder;
  folder.write(
      "remedy.sh",
      "USER=anna\nsudo() { if [ \"$1\" = tee ]; then echo \"$*:\" $(cat); else echo \"$*\"; fi; }\n" + remedy + "\n");
  const std::string command =
      "bash " + (folder.path() / "remedy.sh").string() + " > " + (folder.path() / "out").string() + " 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << remedy;
  std::ifstream file(folder.path() / "out");
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(MachineChecks, FailWhereTheLoopWouldRefuseAndOnlyWarnWhereNothingMoves) {
  Machine machine = sound_machine();
  machine.privileges = {.is_root = false,
                        .fifo_error = EPERM,
                        .rtprio_limit = 0,
                        .memlock_limit_bytes = 8 << 20,
                        .dma_latency_error = EACCES};
  const std::vector<Check> real = check_machine(machine, on_cpu_1(), Stakes::machine);
  EXPECT_EQ(named(real, "scheduling").level, Level::fail);
  EXPECT_NE(named(real, "scheduling").found.find("Operation not permitted"), std::string::npos);
  EXPECT_NE(named(real, "scheduling").remedy.find("rtprio 95"), std::string::npos);
  EXPECT_EQ(named(real, "rtprio").level, Level::fail);
  EXPECT_EQ(named(real, "rtprio").remedy, named(real, "scheduling").remedy) << "one line in one file";
  EXPECT_EQ(printed_by(named(real, "rtprio").remedy),
            "tee -a /etc/security/limits.d/ehad.conf: anna - rtprio 95\nnow log in again\n");
  EXPECT_EQ(named(real, "memlock").level, Level::fail);
  EXPECT_NE(named(real, "memlock").found.find("8192 KiB"), std::string::npos);
  EXPECT_EQ(named(real, "c-states").level, Level::warn);
  EXPECT_EQ(exit_code(real), ExitCode::permission);
  expect_complete(real);
  const std::vector<Check> simulated = check_machine(machine, on_cpu_1(), Stakes::simulated);
  EXPECT_EQ(named(simulated, "scheduling").level, Level::warn);
  EXPECT_EQ(exit_code(simulated), ExitCode::ok);
  expect_complete(simulated);
}

TEST(MachineChecks, LookForTheCauseElsewhereWhenTheLimitAllowsIt) {
  Machine machine = sound_machine();
  machine.privileges.fifo_error = EPERM;
  EXPECT_NE(named(check_machine(machine, on_cpu_1(), Stakes::machine), "scheduling").remedy.find("control group"),
            std::string::npos);
}

TEST(MachineChecks, JudgeTheLimitsOfTheServiceThatDrivesNotThoseOfTheCaller) {
  const test::TemporaryFolder process;
  process.write("status", "Name:\tehad\nUid:\t997\t997\t997\t997\n");
  Privileges caller{.fifo_error = EPERM, .dma_latency_error = EACCES};
  const auto limits = [&](const std::string& rtprio) {
    process.write("limits",
                  "Limit                     Soft Limit           Hard Limit           Units     \n"
                  "Max locked memory         unlimited            unlimited            bytes     \n"
                  "Max realtime priority     " +
                      rtprio + "                   95                            \n");
    return privileges_of_service(process.path(), caller);
  };
  Machine machine = sound_machine();
  machine.privileges = limits("95").value();
  EXPECT_FALSE(machine.privileges.is_root);
  const std::vector<Check> sound = check_machine(machine, on_cpu_1(), Stakes::machine);
  EXPECT_EQ(exit_code(sound), ExitCode::ok);
  expect_complete(sound);
  machine.privileges = limits("0 ").value();
  const Check rtprio = named(check_machine(machine, on_cpu_1(), Stakes::machine), "rtprio");
  EXPECT_EQ(rtprio.level, Level::fail);
  EXPECT_NE(rtprio.found.find("of ehad, which drives: RLIMIT_RTPRIO is 0"), std::string::npos) << rtprio.found;
  EXPECT_EQ(printed_by(rtprio.remedy),
            "mkdir -p /etc/systemd/system/ehad.service.d\n"
            "tee /etc/systemd/system/ehad.service.d/LimitRTPRIO.conf: [Service] LimitRTPRIO=95\n"
            "systemctl daemon-reload\nsystemctl restart ehad\n");
  EXPECT_FALSE(privileges_of_service(process.path() / "gone", caller));
  // Root is the one who can try in its place.
  caller.is_root = true;
  machine.privileges = limits("95").value();
  const std::vector<Check> tried = check_machine(machine, on_cpu_1(), Stakes::machine);
  EXPECT_EQ(named(tried, "scheduling").level, Level::fail);
  EXPECT_NE(named(tried, "scheduling").remedy.find("control group"), std::string::npos);
  EXPECT_EQ(named(tried, "c-states").level, Level::warn);
}

TEST(MachineChecks, NeedNoLimitsForRoot) {
  Machine machine = sound_machine();
  machine.privileges.is_root = true;
  machine.privileges.rtprio_limit = 0;
  machine.privileges.memlock_limit_bytes = 65536;
  EXPECT_EQ(exit_code(check_machine(machine, on_cpu_1(), Stakes::machine)), ExitCode::ok);
}

TEST(MachineChecks, WarnAboutWhatMakesTicksLate) {
  const auto level_after = [](const std::string& name, const std::function<void(Machine&)>& change) {
    Machine machine = sound_machine();
    change(machine);
    const std::vector<Check> checks = check_machine(machine, on_cpu_1(), Stakes::machine);
    expect_complete(checks);
    return named(checks, name).level;
  };
  EXPECT_EQ(level_after("kernel", [](Machine& machine) { machine.kernel.preempt_rt = false; }), Level::warn);
  EXPECT_EQ(level_after("governor", [](Machine& machine) { machine.files.governors = {"powersave"}; }), Level::warn);
  EXPECT_EQ(level_after("rtprio", [](Machine& machine) { machine.privileges.rtprio_limit = 80; }), Level::warn)
      << "enough for the loop, not for its guard";
  EXPECT_EQ(level_after("governor",
                        [](Machine& machine) {
                          machine.files.governors = {"performance", "schedutil"};
                        }),
            Level::warn);
  EXPECT_EQ(level_after("governor", [](Machine& machine) { machine.files.governors.clear(); }), Level::ok);
  EXPECT_EQ(level_after("clock", [](Machine& machine) { machine.files.clock_source = "hpet"; }), Level::warn);
  EXPECT_EQ(level_after("clock", [](Machine& machine) { machine.files.clock_source = "kvm-clock"; }), Level::ok);
  EXPECT_EQ(level_after("cpus", [](Machine& machine) { machine.files.isolated_cpus.clear(); }), Level::warn);
  EXPECT_EQ(level_after("c-states",
                        [](Machine& machine) {
                          machine.privileges.dma_latency_error = ENOENT;
                          machine.files.idle_driver = "none";
                        }),
            Level::ok);
}

TEST(MachineChecks, RefuseALoopBoundToACpuThatIsNotThere) {
  config::RealtimeOptions options;
  options.cpu = 7;
  const std::vector<Check> checks = check_machine(sound_machine(), options, Stakes::simulated);
  EXPECT_EQ(named(checks, "cpus").level, Level::fail);
  EXPECT_NE(named(checks, "cpus").found.find("realtime.cpu is 7, online are 0, 1"), std::string::npos);
  EXPECT_EQ(exit_code(checks), ExitCode::configuration);
}

TEST(MachineChecks, PointOutAnIsolatedCpuThatTheLoopDoesNotUse) {
  const Check cpus = named(check_machine(sound_machine(), {}, Stakes::machine), "cpus");
  EXPECT_EQ(cpus.level, Level::warn);
  EXPECT_EQ(cpus.remedy, "realtime.cpu = 1 in the rig file");
}

TEST(Checks, EndWithTheCodeOfTheWorstFailure) {
  const Check rig = fail("a", "b", "c", ExitCode::configuration);
  const Check device = fail("a", "b", "c", ExitCode::device_unavailable);
  const Check permission = fail("a", "b", "c", ExitCode::permission);
  const Check disk = fail("a", "b", "c", ExitCode::io);
  EXPECT_EQ(exit_code({disk, permission, device, rig}), ExitCode::configuration);
  EXPECT_EQ(exit_code({disk, permission, device}), ExitCode::device_unavailable);
  EXPECT_EQ(exit_code({disk, permission}), ExitCode::permission);
  EXPECT_EQ(exit_code({disk, warn("a", "b", "c")}), ExitCode::io);
  EXPECT_EQ(exit_code({warn("a", "b", "c"), ok("a", "b")}), ExitCode::ok);
}

}  // namespace
}  // namespace eha::doctor
