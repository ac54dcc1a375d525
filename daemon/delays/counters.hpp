// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace eha::delays {

/// A row of /proc/interrupts or /proc/softirqs.
struct InterruptRow {
  std::string device;                  ///< "nvme0q1", "Local timer interrupts"; empty for softirqs
  std::map<int, std::uint64_t> count;  ///< by CPU, since boot
};

/// Times of a CPU by activity since boot [s].
struct CpuTime {
  double busy_s = 0.0;
  double stolen_s = 0.0;  ///< stolen by the host of a virtual machine
};

/// A sleep state of a CPU.
struct SleepState {
  std::string name;           ///< "C6"
  double exit_us = 0.0;       ///< time to wake up [us]
  std::uint64_t entries = 0;  ///< since boot
};

/// A thread of real-time priority.
struct RealtimeThread {
  pid_t process = 0;
  pid_t parent = 0;     ///< of the process; 2 for threads of the kernel
  std::string name;     ///< printable
  int priority = 0;     ///< SCHED_FIFO or SCHED_RR, 1 to 99; SCHED_DEADLINE is 100
  int cpu = 0;          ///< on which it last ran
  double used_s = 0.0;  ///< processor time [s]
};

/// Counters of a machine since boot; a member is empty if the kernel does not report it.
struct Counters {
  double uptime_s = 0.0;
  std::map<std::string, InterruptRow> interrupts;  ///< by number or name: "130", "LOC"
  std::map<std::string, InterruptRow> softirqs;    ///< by name: "NET_RX"
  std::map<int, CpuTime> cpus;
  std::map<int, std::vector<SleepState>> sleep;  ///< by CPU
  std::map<int, std::uint64_t> smi;              ///< system management interrupts by CPU; needs root and the module msr
  std::map<pid_t, RealtimeThread> realtime_threads;  ///< by thread
};

/// Reads /proc, /sys and /dev/cpu/*/msr. Cost: some ten microseconds for each thread of the machine; not for the loop's
/// thread. Throws nothing but std::bad_alloc.
/// @param root  "/", or a folder laid out like it
[[nodiscard]] Counters read_counters(const std::filesystem::path& root);

}  // namespace eha::delays
