// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <limits>

namespace eha::doctor {

/// The privileges of this process.
struct Privileges {
  static constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

  bool is_root = false;                   ///< effective user 0
  int fifo_error = 0;                     ///< errno of a thread's request for SCHED_FIFO; 0 if granted
  std::uint64_t rtprio_limit = 0;         ///< RLIMIT_RTPRIO
  std::uint64_t memlock_limit_bytes = 0;  ///< RLIMIT_MEMLOCK
  int dma_latency_error = 0;              ///< errno of opening /dev/cpu_dma_latency for writing; 0 when it opens
};

/// Tries SCHED_FIFO in a short-lived thread and reads the limits; changes nothing permanently.
/// @param priority  1..99
[[nodiscard]] Privileges probe_privileges(int priority);

}  // namespace eha::doctor
