// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "daemon/delays/delays.hpp"
#include "daemon/delays/kernel_files.hpp"
#include "daemon/delays/machine_facts.hpp"

namespace eha::delays {
namespace {

namespace fs = std::filesystem;

constexpr double kLeastShare = 0.5;  // of a CPU that real-time threads may use
constexpr pid_t kKernelThreads = 2;

bool contains(const std::vector<int>& cpus, int cpu) { return std::find(cpus.begin(), cpus.end(), cpu) != cpus.end(); }

std::string boot_with(const std::string& words) {
  return fmt::format("add {} to GRUB_CMDLINE_LINUX in /etc/default/grub, then sudo update-grub and reboot", words);
}

/// Returns the CPUs of a parameter of the kernel's command line, such as rcu_nocbs=2-3.
std::vector<int> boot_cpus(const fs::path& root, std::string_view parameter) {
  std::istringstream words(first_line(root / "proc/cmdline"));
  for (std::string word; words >> word;) {
    if (word.starts_with(parameter) && word.size() > parameter.size() && word[parameter.size()] == '=') {
      return cpu_list(std::string_view(word).substr(parameter.size() + 1));
    }
  }
  return {};
}

/// Returns the devices whose interrupts go to the CPU.
void add_interrupts(const fs::path& root, const Counters& now, int cpu, std::vector<Delay>& delays) {
  constexpr std::size_t kNamed = 3;
  std::vector<std::pair<std::uint64_t, std::string>> served;
  for (const auto& [number, row] : now.interrupts) {
    const auto count = row.count.find(cpu);
    if (std::isdigit(static_cast<unsigned char>(number.front())) == 0 || count == row.count.end() ||
        count->second == 0) {
      continue;
    }
    const fs::path folder = root / "proc/irq" / number;
    std::string list = first_line(folder / "effective_affinity_list");
    if (list.empty()) list = first_line(folder / "smp_affinity_list");
    if (contains(cpu_list(list), cpu)) served.emplace_back(count->second, fmt::format("{} ({})", number, row.device));
  }
  if (served.empty()) return;
  std::sort(served.rbegin(), served.rend());
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(kNamed, served.size()); ++i) names.push_back(served[i].second);
  delays.push_back({"interrupts",
                    fmt::format("CPU {} serves the interrupts of {} devices: {}{}", cpu, served.size(),
                                fmt::join(names, ", "), served.size() > kNamed ? ", ..." : ""),
                    "echo OTHER_CPU | sudo tee /proc/irq/N/smp_affinity_list for each, and "
                    "IRQBALANCE_BANNED_CPULIST in /etc/default/irqbalance; or irqaffinity= at boot"});
}

void add_kernel_work(const fs::path& root, int cpu, std::vector<Delay>& delays) {
  const std::vector<int> quiet = cpu_list(first_line(root / "sys/devices/system/cpu/nohz_full"));
  if (!contains(quiet, cpu)) {
    delays.push_back({"tick", fmt::format("the kernel's own tick runs on CPU {} (no nohz_full)", cpu),
                      boot_with(fmt::format("nohz_full={}", cpu))});
    if (!contains(boot_cpus(root, "rcu_nocbs"), cpu)) {
      delays.push_back({"rcu", fmt::format("the kernel frees memory on CPU {} (no rcu_nocbs)", cpu),
                        boot_with(fmt::format("rcu_nocbs={}", cpu))});
    }
  }
  const fs::path kernel = root / "proc/sys/kernel";
  if (first_line(kernel / "nmi_watchdog") == "1") {
    delays.push_back({"watchdog", fmt::format("the watchdog for hard lock-ups interrupts CPU {}", cpu),
                      "sudo sysctl kernel.nmi_watchdog=0"});
  }
  if (first_line(kernel / "soft_watchdog") == "1" && contains(cpu_list(first_line(kernel / "watchdog_cpumask")), cpu)) {
    delays.push_back({"watchdog",
                      fmt::format("the watchdog for soft lock-ups runs above every priority on CPU {}", cpu),
                      "sudo sysctl kernel.watchdog_cpumask=OTHER_CPUS"});
  }
}

void add_rivals(const Counters& now, const LoopThread& loop, std::vector<Delay>& delays) {
  for (const auto& [tid, thread] : now.realtime_threads) {
    const bool is_kernels = thread.parent == kKernelThreads || thread.process == kKernelThreads;
    const bool is_ours = thread.name == kGuard || thread.name == kLoop || thread.process == loop.process;
    if (is_kernels || is_ours || thread.priority < loop.priority) continue;
    const bool has_priority = loop.priority > 0;
    delays.push_back({"priority",
                      fmt::format("thread {} \"{}\" has real-time priority {}, the loop {}", tid, thread.name,
                                  thread.priority, loop.priority),
                      has_priority ? fmt::format("sudo chrt --fifo --pid {} {}", std::max(1, loop.priority / 2), tid)
                                   : std::string(kNoPriority)});
    if (!has_priority) return;  // the same helps against all
  }
}

bool is_virtual(const fs::path& root) {
  std::ifstream stream(root / "proc/cpuinfo");
  for (std::string line; std::getline(stream, line);) {
    if (!line.starts_with("flags")) continue;
    std::istringstream words(line);
    for (std::string word; words >> word;) {
      if (word == "hypervisor") return true;
    }
    return false;
  }
  return false;
}

}  // namespace

std::vector<Delay> standing_delays(const fs::path& root, const Counters& now, const LoopThread& loop) {
  std::vector<Delay> delays;
  add_rivals(now, loop, delays);
  if (const auto share = realtime_share(root); share && *share < kLeastShare) {
    delays.push_back(
        {"throttling",
         fmt::format("real-time threads may use {:.0f} % of a CPU (kernel.sched_rt_runtime_us)", 100.0 * *share),
         "sudo sysctl kernel.sched_rt_runtime_us=950000"});
  }
  if (is_virtual(root)) {
    delays.push_back({"host", "a virtual machine: its host may take a CPU away for milliseconds",
                      "run the rig from a machine of its own, without a host"});
  }
  if (loop.cpu) {
    for (const int half : other_halves(root, *loop.cpu)) {
      delays.push_back({"sibling", fmt::format("CPU {} is the other half of the core of CPU {}", half, *loop.cpu),
                        std::string(kHalvesRemedy)});
    }
    add_interrupts(root, now, *loop.cpu, delays);
    add_kernel_work(root, *loop.cpu, delays);
  }
  if (const auto most = std::max_element(now.smi.begin(), now.smi.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
      most != now.smi.end() && most->second > 0) {
    delays.push_back(
        {"firmware",
         fmt::format("{} system management interrupts since boot: each stops the whole machine", most->second),
         "in the firmware's set-up switch off legacy USB, power management and fan control by it; "
         "hwlatdetect (package rt-tests) measures them"});
  }
  return delays;
}

}  // namespace eha::delays
