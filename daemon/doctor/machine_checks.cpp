// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/machine_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string>
#include <string_view>

#include "core/error.hpp"
#include "core/priorities.hpp"

namespace eha::doctor {
namespace {

bool contains(const std::vector<int>& cpus, int cpu) { return std::find(cpus.begin(), cpus.end(), cpu) != cpus.end(); }

/// An unmet requirement, without which the loop refuses to move a machine.
Check missing(std::string name, std::string found, std::string remedy, Stakes stakes) {
  if (stakes == Stakes::simulated) return warn(std::move(name), std::move(found), std::move(remedy));
  return fail(std::move(name), std::move(found), std::move(remedy), ExitCode::permission);
}

/// A command that works as it is copied. @param unit_setting  the same limit in the service's unit
std::string raise_limit(const Privileges& privileges, const std::string& limit, const char* unit_setting) {
  if (privileges.is_of_service) {
    const std::string folder = "/etc/systemd/system/ehad.service.d";
    const std::string_view setting(unit_setting);
    return fmt::format(
        "sudo mkdir -p {0} && printf '[Service]\\n{1}\\n' | sudo tee {0}/{2}.conf && sudo systemctl daemon-reload && "
        "sudo systemctl restart ehad",
        folder, setting, setting.substr(0, setting.find('=')));
  }
  return fmt::format("echo \"$USER - {}\" | sudo tee -a /etc/security/limits.d/ehad.conf && echo 'now log in again'",
                     limit);
}

std::string raise_rtprio(const Privileges& privileges) {
  return raise_limit(privileges, fmt::format("rtprio {}", kGuardPriority),
                     fmt::format("LimitRTPRIO={}", kGuardPriority).c_str());
}

/// Whose limits are judged: the service drives the rig, and a user's own are of --local alone.
std::string whose(const Privileges& privileges) { return privileges.is_of_service ? "of ehad, which drives: " : ""; }

Check check_kernel(const acquisition::KernelFacts& kernel) {
  if (kernel.preempt_rt) return ok("kernel", kernel.release + ", PREEMPT_RT");
  return warn("kernel", kernel.release + ", not PREEMPT_RT: expect ticks late by milliseconds now and then",
              "sudo apt-get install linux-image-rt-$(dpkg --print-architecture) && echo 'now reboot into it'");
}

Check check_scheduling(const Privileges& privileges, int priority, Stakes stakes) {
  if (!privileges.are_grants_tried) {
    return ok("scheduling", "not tried for ehad, which drives: its limit is judged below; sudo eha doctor tries it");
  }
  if (privileges.fifo_error == 0) return ok("scheduling", fmt::format("SCHED_FIFO {} is granted", priority));
  const bool limit_allows =
      privileges.is_root || privileges.is_of_service || privileges.rtprio_limit >= static_cast<std::uint64_t>(priority);
  return missing("scheduling", fmt::format("SCHED_FIFO {} is refused: {}", priority, error_text(privileges.fifo_error)),
                 limit_allows ? "the limit allows it, so a container or control group forbids it: grant CAP_SYS_NICE, "
                                "or cpu.rt_runtime_us above 0"
                              : raise_rtprio(privileges),
                 stakes);
}

Check check_rtprio(const Privileges& privileges, int priority, Stakes stakes) {
  if (privileges.is_root) return ok("rtprio", whose(privileges) + "no limit for root");
  const std::string found = whose(privileges) + (privileges.rtprio_limit == Privileges::kUnlimited
                                                     ? "unlimited"
                                                     : fmt::format("RLIMIT_RTPRIO is {}", privileges.rtprio_limit));
  const std::string remedy = raise_rtprio(privileges);
  if (privileges.rtprio_limit < static_cast<std::uint64_t>(priority)) {
    return missing("rtprio", fmt::format("{}, the loop asks for {}", found, priority), remedy, stakes);
  }
  const bool guard_may = privileges.rtprio_limit >= static_cast<std::uint64_t>(kGuardPriority);
  if (stakes == Stakes::simulated || guard_may) return ok("rtprio", found);
  return warn("rtprio",
              fmt::format("{}, the guard asks for {}: a process that starves the loop may starve the guard too", found,
                          kGuardPriority),
              remedy);
}

Check check_memlock(const Privileges& privileges, Stakes stakes) {
  if (privileges.is_root) return ok("memlock", whose(privileges) + "no limit for root");
  if (privileges.memlock_limit_bytes == Privileges::kUnlimited) return ok("memlock", whose(privileges) + "unlimited");
  return missing("memlock",
                 fmt::format("{}RLIMIT_MEMLOCK is {} KiB; the loop locks all its memory, and only without a limit",
                             whose(privileges), privileges.memlock_limit_bytes / 1024),
                 raise_limit(privileges, "memlock unlimited", "LimitMEMLOCK=infinity"), stakes);
}

Check check_governor(const std::vector<std::string>& governors) {
  if (governors.empty()) return ok("governor", "no frequency scaling");
  if (governors.size() == 1 && governors.front() == "performance") return ok("governor", "performance");
  return warn("governor", fmt::format("{}: the CPU slows down between ticks", fmt::join(governors, ", ")),
              "echo performance | sudo tee /sys/devices/system/cpu/cpufreq/policy*/scaling_governor");
}

Check check_cpus(const SystemFiles& files, std::optional<int> cpu, Stakes stakes) {
  const std::string isolated = files.isolated_cpus.empty()
                                   ? "no CPU is isolated"
                                   : fmt::format("isolated: {}", fmt::join(files.isolated_cpus, ", "));
  const auto isolate = [](int number) {
    return fmt::format("add isolcpus={} to GRUB_CMDLINE_LINUX in /etc/default/grub, then sudo update-grub and reboot",
                       number);
  };
  if (cpu && !files.online_cpus.empty() && !contains(files.online_cpus, *cpu)) {
    return fail("cpus", fmt::format("realtime.cpu is {}, online are {}", *cpu, fmt::join(files.online_cpus, ", ")),
                "name a CPU that is online in the rig file", ExitCode::configuration);
  }
  if (cpu && contains(files.isolated_cpus, *cpu)) return ok("cpus", fmt::format("the loop has CPU {} to itself", *cpu));
  if (cpu) {
    return warn("cpus", fmt::format("the loop is bound to CPU {} and shares it; {}", *cpu, isolated), isolate(*cpu));
  }
  if (!files.isolated_cpus.empty()) {
    return warn("cpus", isolated + "; the loop is bound to none",
                fmt::format("realtime.cpu = {} in the rig file", files.isolated_cpus.back()));
  }
  if (stakes == Stakes::simulated || files.online_cpus.size() < 2) return ok("cpus", isolated);
  return warn("cpus", isolated + "; the loop is bound to none",
              fmt::format("realtime.cpu = {} in the rig file; {}", files.online_cpus.back(),
                          isolate(files.online_cpus.back())));
}

Check check_sleep(const std::string& idle_driver, const Privileges& privileges) {
  const int dma_latency_error = privileges.dma_latency_error;
  if (!privileges.are_grants_tried) {
    return ok("c-states", "not tried for ehad, which drives; sudo eha doctor tries it");
  }
  if (dma_latency_error == 0) return ok("c-states", "deep sleep can be held off (/dev/cpu_dma_latency)");
  if (idle_driver == "none") return ok("c-states", "no idle driver, no deep sleep");
  return warn(
      "c-states", fmt::format("deep sleep cannot be held off: /dev/cpu_dma_latency: {}", error_text(dma_latency_error)),
      dma_latency_error == ENOENT ? "boot with cpuidle.off=1"
                                  : "echo 'KERNEL==\"cpu_dma_latency\", GROUP=\"iocard\", MODE=\"0660\"' | sudo tee "
                                    "/etc/udev/rules.d/70-cpu-dma-latency.rules, then reboot");
}

Check check_clock(const SystemFiles& files) {
  // Each read of these is a bus access of about a microsecond, or counts timer interrupts only.
  constexpr std::array<const char*, 5> kSlow{"hpet", "acpi_pm", "pit", "jiffies", "refined-jiffies"};
  if (files.clock_source.empty()) return warn("clock", "the clock source is unknown: no /sys", "mount /sys");
  if (std::find(kSlow.begin(), kSlow.end(), files.clock_source) == kSlow.end()) return ok("clock", files.clock_source);
  const bool has_tsc =
      std::find(files.clock_sources.begin(), files.clock_sources.end(), "tsc") != files.clock_sources.end();
  return warn("clock", fmt::format("{}: slow to read or coarse", files.clock_source),
              has_tsc ? "echo tsc | sudo tee /sys/devices/system/clocksource/clocksource0/current_clocksource"
                      : "boot with tsc=reliable if the CPU's counter is steady (constant_tsc nonstop_tsc in "
                        "/proc/cpuinfo)");
}

}  // namespace

std::vector<Check> check_machine(const Machine& machine, const config::RealtimeOptions& realtime, Stakes stakes) {
  const int priority = std::min(realtime.priority, kHighestLoopPriority);
  return {check_kernel(machine.kernel),
          check_scheduling(machine.privileges, priority, stakes),
          check_rtprio(machine.privileges, priority, stakes),
          check_memlock(machine.privileges, stakes),
          check_governor(machine.files.governors),
          check_cpus(machine.files, realtime.cpu, stakes),
          check_sleep(machine.files.idle_driver, machine.privileges),
          check_clock(machine.files)};
}

}  // namespace eha::doctor
