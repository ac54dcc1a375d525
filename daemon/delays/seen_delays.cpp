// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "daemon/delays/delays.hpp"
#include "daemon/delays/machine_facts.hpp"

namespace eha::delays {
namespace {

constexpr double kShortest_s = 0.1;
constexpr double kSlowWake_us = 50.0;  // limit of eha latency
constexpr double kRivalShare = 0.002;  // of a processor: 2 us a tick of 1 ms, or one of 50 ms in 25 s
constexpr double kStolenShare = 0.001;
constexpr double kBusyHalf = 0.2;
constexpr double kThrottleShare = 0.9;  // of the time allowed to real-time threads

/// Rate above which a row of /proc/interrupts or /proc/softirqs delays a CPU [1/s].
struct NamedRow {
  std::string_view name;
  double most_per_s;
  std::string_view sentence;  ///< {0}: times a second, {1}: CPU
  std::string_view remedy;    ///< {1}: CPU
};

constexpr double kDeviceMost_per_s = 1000.0;
constexpr auto kInterrupts = std::to_array<NamedRow>({
    {"TRM", 0.0, "CPU {1} was throttled for its heat ({0:.3g} events a second)", "cool it; clean fan and filter"},
    {"NMI", 20.0, "{0:.0f} non-maskable interrupts a second on CPU {1}",
     "sudo sysctl kernel.nmi_watchdog=0, and end perf"},
    {"TLB", 2000.0,
     "{0:.0f} requests a second to CPU {1} to forget addresses: other threads of the process free memory",
     "end what allocates and frees memory all the time"},
    {"CAL", 2000.0, "{0:.0f} function calls a second from other CPUs to CPU {1}",
     "isolate CPU {1}: isolcpus=managed_irq,domain,{1} nohz_full={1} on the kernel's command line"},
    {"RES", 5000.0, "{0:.0f} requests a second to CPU {1} to schedule anew",
     "bind what wakes threads there to other CPUs, or isolate CPU {1} (isolcpus={1})"},
    {"LOC", 8000.0, "{0:.0f} timer interrupts a second on CPU {1}", "bind programs with fast timers to other CPUs"},
});
constexpr auto kSoftirqs = std::to_array<NamedRow>({
    {"NET_RX", 2000.0, "network packets kept CPU {1} {0:.0f} times a second",
     "move the network card's interrupts to another CPU (/proc/irq/N/smp_affinity_list)"},
    {"NET_TX", 2000.0, "network packets kept CPU {1} {0:.0f} times a second",
     "move the network card's interrupts to another CPU (/proc/irq/N/smp_affinity_list)"},
    {"BLOCK", 2000.0, "a disk kept CPU {1} {0:.0f} times a second",
     "move the disk's interrupts to another CPU (/proc/irq/N/smp_affinity_list)"},
    {"TASKLET", 2000.0, "a device's driver kept CPU {1} {0:.0f} times a second (tasklets)",
     "move the interrupts of sound and USB to another CPU (/proc/irq/N/smp_affinity_list)"},
});

struct Span {
  const std::filesystem::path& root;
  const Counters& before;
  const Counters& after;
  const LoopThread& loop;
  double seconds;

  [[nodiscard]] bool concerns(int cpu) const { return !loop.cpu || *loop.cpu == cpu; }
};

/// The CPU of the loop on which a row counted fastest, and its rate [1/s].
std::pair<int, double> fastest(const Span& span, const InterruptRow* before, const InterruptRow& after) {
  std::pair<int, double> most{-1, 0.0};
  for (const auto& [cpu, count] : after.count) {
    if (!span.concerns(cpu)) continue;
    std::uint64_t earlier = 0;
    if (before != nullptr) {
      if (const auto at = before->count.find(cpu); at != before->count.end()) earlier = at->second;
    }
    const double rate = count > earlier ? static_cast<double>(count - earlier) / span.seconds : 0.0;
    if (rate > most.second) most = {cpu, rate};
  }
  return most;
}

const InterruptRow* row_of(const std::map<std::string, InterruptRow>& rows, std::string_view name) {
  const auto row = rows.find(std::string(name));
  return row == rows.end() ? nullptr : &row->second;
}

void add_named(const Span& span, const auto& named, const std::map<std::string, InterruptRow>& before,
               const std::map<std::string, InterruptRow>& after, const char* name, std::vector<Delay>& delays) {
  for (const NamedRow& row : named) {
    const InterruptRow* const now = row_of(after, row.name);
    if (now == nullptr) continue;
    const auto [cpu, rate] = fastest(span, row_of(before, row.name), *now);
    if (rate <= row.most_per_s) continue;
    delays.push_back(
        {name, fmt::format(fmt::runtime(row.sentence), rate, cpu), fmt::format(fmt::runtime(row.remedy), rate, cpu)});
  }
}

void add_interrupts(const Span& span, std::vector<Delay>& delays) {
  for (const auto& [number, row] : span.after.interrupts) {
    if (std::isdigit(static_cast<unsigned char>(number.front())) == 0) continue;
    const auto [cpu, rate] = fastest(span, row_of(span.before.interrupts, number), row);
    if (rate <= kDeviceMost_per_s) continue;
    delays.push_back(
        {"interrupts",
         fmt::format("interrupt {} ({}) came {:.0f} times a second to CPU {}", number, row.device, rate, cpu),
         fmt::format("echo OTHER_CPU | sudo tee /proc/irq/{}/smp_affinity_list", number)});
  }
  add_named(span, kInterrupts, span.before.interrupts, span.after.interrupts, "interrupts", delays);
  add_named(span, kSoftirqs, span.before.softirqs, span.after.softirqs, "softirqs", delays);
}

/// Processor time of a thread between the readings [s].
double used_s(const Span& span, pid_t tid, const RealtimeThread& thread) {
  const auto earlier = span.before.realtime_threads.find(tid);
  const bool is_known = earlier != span.before.realtime_threads.end() && earlier->second.process == thread.process;
  return std::max(0.0, thread.used_s - (is_known ? earlier->second.used_s : 0.0));
}

void add_rivals(const Span& span, std::vector<Delay>& delays) {
  std::optional<Delay> worst;  // of those that nothing but a priority of the loop's own helps against
  double longest_s = 0.0;
  for (const auto& [tid, thread] : span.after.realtime_threads) {
    if (thread.process == span.loop.process || thread.priority < span.loop.priority || thread.name == kGuard) continue;
    const double used = used_s(span, tid, thread);
    if (!span.concerns(thread.cpu) || used <= kRivalShare * span.seconds) continue;
    Delay found{
        "priority",
        fmt::format("thread {} \"{}\" of real-time priority {} had CPU {} for {:.3g} s of {:.3g} s; the loop has {}",
                    tid, thread.name, thread.priority, thread.cpu, used, span.seconds, span.loop.priority),
        std::string(kNoPriority)};
    if (thread.name == kLoop) {
      found.remedy = "two rigs are driven on one CPU: another `cpu` in [realtime] of one rig file";
    } else if (span.loop.priority > 0) {
      found.remedy = fmt::format(
          "sudo chrt --fifo --pid {} {}, or bind it to another CPU: sudo taskset --cpu-list --pid OTHER_CPU {}",
          std::max(1, span.loop.priority / 2), tid, tid);
    } else {
      if (used > longest_s) worst = std::move(found);
      longest_s = std::max(longest_s, used);
      continue;
    }
    delays.push_back(std::move(found));
  }
  if (worst) delays.push_back(std::move(*worst));
}

void add_throttling(const Span& span, std::vector<Delay>& delays) {
  const std::optional<double> allowed = realtime_share(span.root);
  if (!allowed) return;
  std::map<int, double> used;
  for (const auto& [tid, thread] : span.after.realtime_threads) used[thread.cpu] += used_s(span, tid, thread);
  for (const auto& [cpu, seconds] : used) {
    const double share = seconds / span.seconds;
    if (!span.concerns(cpu) || share < kThrottleShare * *allowed) continue;
    delays.push_back(
        {"throttling",
         fmt::format("real-time threads used {:.0f} % of CPU {}, where the kernel stops them all, the loop "
                     "too, beyond {:.0f} % (kernel.sched_rt_runtime_us)",
                     100.0 * share, cpu, 100.0 * *allowed),
         "end the thread that never sleeps, or bind it to another CPU; then sudo sysctl "
         "kernel.sched_rt_runtime_us=-1"});
  }
}

void add_cpus(const Span& span, std::vector<Delay>& delays) {
  std::vector<std::string> cpus;
  std::vector<std::string> stolen_s;
  for (const auto& [cpu, now] : span.after.cpus) {
    const auto earlier = span.before.cpus.find(cpu);
    if (earlier == span.before.cpus.end() || !span.concerns(cpu)) continue;
    const double stolen = now.stolen_s - earlier->second.stolen_s;
    if (stolen > kStolenShare * span.seconds) {
      cpus.push_back(fmt::format("{}", cpu));
      stolen_s.push_back(fmt::format("{:.3g}", stolen));
    }
  }
  if (!cpus.empty()) {
    delays.push_back(
        {"host",
         fmt::format("the host of this virtual machine took CPU{} {} away for {} s of {:.3g} s",
                     cpus.size() == 1 ? "" : "s", fmt::join(cpus, ", "), fmt::join(stolen_s, ", "), span.seconds),
         "run the rig from a machine of its own, without a host"});
  }
  if (!span.loop.cpu) return;
  for (const int half : other_halves(span.root, *span.loop.cpu)) {
    const auto now = span.after.cpus.find(half);
    const auto earlier = span.before.cpus.find(half);
    if (now == span.after.cpus.end() || earlier == span.before.cpus.end()) continue;
    const double share = (now->second.busy_s - earlier->second.busy_s) / span.seconds;
    if (share <= kBusyHalf) continue;
    delays.push_back({"sibling",
                      fmt::format("CPU {}, the other half of the core of CPU {}, was busy for {:.0f} % of the time",
                                  half, *span.loop.cpu, 100.0 * share),
                      std::string(kHalvesRemedy)});
  }
}

void add_sleep(const Span& span, std::vector<Delay>& delays) {
  for (const auto& [cpu, states] : span.after.sleep) {
    const auto earlier = span.before.sleep.find(cpu);
    if (earlier == span.before.sleep.end() || !span.concerns(cpu)) continue;
    for (const SleepState& state : states) {
      const auto same = std::find_if(earlier->second.begin(), earlier->second.end(),
                                     [&](const SleepState& one) { return one.name == state.name; });
      if (state.exit_us <= kSlowWake_us || same == earlier->second.end()) continue;
      const double rate = static_cast<double>(state.entries - same->entries) / span.seconds;
      if (state.entries <= same->entries || rate < 1.0) continue;
      delays.push_back({"sleep",
                        fmt::format("CPU {} slept in state {} {:.0f} times a second; waking up takes {:.0f} us", cpu,
                                    state.name, rate, state.exit_us),
                        "let the loop hold /dev/cpu_dma_latency (eha doctor), or boot with cpuidle.off=1"});
    }
  }
}

void add_smi(const Span& span, std::vector<Delay>& delays) {
  std::uint64_t most = 0;
  for (const auto& [cpu, count] : span.after.smi) {
    const auto earlier = span.before.smi.find(cpu);
    if (earlier != span.before.smi.end() && count > earlier->second) most = std::max(most, count - earlier->second);
  }
  if (most == 0) return;
  delays.push_back({"firmware",
                    fmt::format("{} system management interrupts: the firmware stopped the whole machine", most),
                    "in the firmware's set-up switch off legacy USB, power management and fan control by it; "
                    "hwlatdetect (package rt-tests) measures them"});
}

}  // namespace

std::vector<Delay> seen_delays(const std::filesystem::path& root, const Counters& before, const Counters& after,
                               const LoopThread& loop) {
  const Span span{root, before, after, loop, after.uptime_s - before.uptime_s};
  std::vector<Delay> delays;
  if (!(span.seconds >= kShortest_s)) return delays;
  add_rivals(span, delays);
  if (delays.empty() && loop.preemptions > 0) {
    // A service may not see the threads of others (ProtectProc).
    delays.push_back({"priority",
                      fmt::format("threads of higher priority took the loop's place {} times", loop.preemptions),
                      "sudo eha latency names them while they run"});
  }
  add_throttling(span, delays);
  add_cpus(span, delays);
  add_interrupts(span, delays);
  add_smi(span, delays);
  add_sleep(span, delays);
  return delays;
}

std::string sentence_of(const Delay& delay) { return "late ticks: " + delay.found + "; " + delay.remedy; }

}  // namespace eha::delays
