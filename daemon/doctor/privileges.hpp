// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>

namespace eha::doctor {

/// The privileges of this process, or those of the service's.
struct Privileges {
  static constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

  bool is_root = false;                   ///< effective user 0
  int fifo_error = 0;                     ///< errno of a thread's request for SCHED_FIFO; 0 if granted
  std::uint64_t rtprio_limit = 0;         ///< RLIMIT_RTPRIO
  std::uint64_t memlock_limit_bytes = 0;  ///< RLIMIT_MEMLOCK
  int dma_latency_error = 0;              ///< errno of opening /dev/cpu_dma_latency for writing; 0 when it opens
  bool is_of_service = false;             ///< the limits are; what is granted to it is tried in its place by root alone
  bool are_grants_tried = true;           ///< whether both errors are known
};

/// Tries SCHED_FIFO in a short-lived thread and reads the limits; changes nothing permanently.
/// @param priority  1..99
[[nodiscard]] Privileges probe_privileges(int priority);

/// Reads the limits of a running service. @param process  its folder in /proc   @returns none if they cannot be read
/// @param caller  of this process: what is not granted to root is granted to no service on this machine
[[nodiscard]] std::optional<Privileges> privileges_of_service(const std::filesystem::path& process,
                                                              const Privileges& caller);

}  // namespace eha::doctor
