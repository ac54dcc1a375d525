// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/delays/counters.hpp"

// Causes of late ticks: properties and events of a machine that can delay the loop.

namespace eha::delays {

/// One cause of late ticks.
struct Delay {
  std::string name;    ///< "interrupts"
  std::string found;   ///< "interrupt 130 (nvme0q1) came 5200 times a second to CPU 1"
  std::string remedy;  ///< command or change
};

/// The remedy where the loop has none, against which no priority of another thread helps.
inline constexpr std::string_view kNoPriority =
    "the loop needs a real-time priority of its own: `eha doctor` says how it gets one";

/// The thread that keeps the ticks.
struct LoopThread {
  std::optional<int> cpu = {};   ///< bound to it; none: it runs on any
  int priority = 0;              ///< SCHED_FIFO
  pid_t process = 0;             ///< its own threads are never causes
  std::int64_t preemptions = 0;  ///< number of preemptions by other threads
};

/// Finds causes in the machine's settings: interrupts and kernel work on the loop's CPU, the other half of its core,
/// threads of higher priority, too small a share of real-time threads, a virtual machine's host.
/// Most causes need a loop that is bound to a CPU.
/// @param root  "/", or a folder laid out like it
[[nodiscard]] std::vector<Delay> standing_delays(const std::filesystem::path& root, const Counters& now,
                                                 const LoopThread& loop);

/// Finds causes in the events between two readings of the counters. Empty if the counters show none, or were read less
/// than 0.1 s apart. Does not see a thread that ended before the second reading.
/// @param root  for the share of real-time threads and the halves of cores
[[nodiscard]] std::vector<Delay> seen_delays(const std::filesystem::path& root, const Counters& before,
                                             const Counters& after, const LoopThread& loop);

/// "late ticks: FOUND; REMEDY", for messages.
[[nodiscard]] std::string sentence_of(const Delay& delay);

}  // namespace eha::delays
