// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/delays/kernel_files.hpp"

namespace eha::delays {

/// Returns the other CPUs of the same core (simultaneous multithreading).
[[nodiscard]] inline std::vector<int> other_halves(const std::filesystem::path& root, int cpu) {
  std::vector<int> cpus = cpu_list(
      first_line(root / "sys/devices/system/cpu" / ("cpu" + std::to_string(cpu)) / "topology/thread_siblings_list"));
  std::erase(cpus, cpu);
  return cpus;
}

/// Whether a thread is the rig's guard, which runs above the loop on purpose and needs little time.
inline constexpr std::string_view kGuard = "eha-safe";
/// The thread of a loop: another process's is that of the service, which is to have its place.
inline constexpr std::string_view kLoop = "eha-loop";

inline constexpr std::string_view kHalvesRemedy = "echo off | sudo tee /sys/devices/system/cpu/smt/control";

/// Returns the share of a CPU that the kernel allows all real-time threads, 0 to 1; none: no limit, or unknown.
[[nodiscard]] inline std::optional<double> realtime_share(const std::filesystem::path& root) {
  const double runtime = std::atof(first_line(root / "proc/sys/kernel/sched_rt_runtime_us").c_str());
  const double period = std::atof(first_line(root / "proc/sys/kernel/sched_rt_period_us").c_str());
  if (!(runtime > 0.0 && period > 0.0 && runtime < period)) return std::nullopt;
  return runtime / period;
}

}  // namespace eha::delays
