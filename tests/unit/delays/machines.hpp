// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

#include "tests/unit/temporary_folder.hpp"

// Machines as trees of /proc, /sys and /dev: each as it stands, and what changes in it while a loop runs.

namespace eha::delays {

/// A folder laid out like "/".
class Machine {
 public:
  void write(const std::string& file, std::string_view content) const {
    std::filesystem::create_directories((folder_.path() / file).parent_path());
    folder_.write(file, content);
  }
  /// A thread as /proc has it. @param used  hundredths of a second
  void thread(int process, int tid, const std::string& name, int priority, int cpu, int used, int parent = 1) const {
    std::string stat = fmt::format("{} ({}) S {} 1 1 0 -1 64 0 0 0 0 {} 0 0 0 -2 0 1 0 4242", tid, name, parent, used);
    for (int field = 23; field < 38; ++field) stat += " 0";
    write(fmt::format("proc/{}/task/{}/stat", process, tid),
          stat + fmt::format(" 17 {} {} {} 0 0 0 0 0 0 0 0 0 0 0\n", cpu, priority, priority > 0 ? 1 : 0));
  }
  void smi(int cpu, std::uint64_t count) const {
    std::string registers(0x34 + 8, '\0');
    std::memcpy(registers.data() + 0x34, &count, sizeof count);
    write(fmt::format("dev/cpu/{}/msr", cpu), registers);
  }
  void sleep_state(int cpu, int state, const char* name, int exit_us, int entries) const {
    const std::string folder = fmt::format("sys/devices/system/cpu/cpu{}/cpuidle/state{}/", cpu, state);
    write(folder + "name", std::string(name) + "\n");
    write(folder + "latency", fmt::format("{}\n", exit_us));
    write(folder + "usage", fmt::format("{}\n", entries));
  }
  void halves(int cpu, const char* list) const {
    write(fmt::format("sys/devices/system/cpu/cpu{}/topology/thread_siblings_list", cpu), std::string(list) + "\n");
  }
  /// What each tree has: 100 s have passed, nobody stole or was busy.
  void common() const {
    write("proc/uptime", "1000.00 1900.00\n");
    write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
    write("proc/sys/kernel/sched_rt_period_us", "1000000\n");
    thread(2, 2, "kthreadd", 0, 0, 1, 0);
    thread(20, 20, "migration/1", 99, 1, 4, 2);
    thread(500, 501, "eha-loop", 80, 1, 10);
    thread(600, 600, "eha-safe", 95, 0, 50);
  }
  void passes(const char* uptime) const { write("proc/uptime", uptime); }
  [[nodiscard]] const std::filesystem::path& root() const { return folder_.path(); }

 private:
  test::TemporaryFolder folder_;
};

constexpr const char* kFourCpus =
    "           CPU0       CPU1       CPU2       CPU3       \n"
    "  0:         34          0          0          0   IO-APIC   2-edge      timer\n";

}  // namespace eha::delays
