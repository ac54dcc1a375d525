// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

#include "config/rig_config.hpp"
#include "core/os/file_descriptor.hpp"
#include "daemon/acquisition/run.hpp"

namespace eha::acquisition {

/// Kernel of the machine.
struct KernelFacts {
  std::string release;      ///< "6.1.0-25-rt-amd64"
  std::string version;      ///< "#1 SMP PREEMPT_RT Debian ..."
  bool preempt_rt = false;  ///< /sys/kernel/realtime, or PREEMPT_RT in the version
};

[[nodiscard]] KernelFacts kernel_facts();

/// Returns the time without a beat after which the guard acts [ns]: a period, in which the loop sleeps, plus the rig
/// file's stall_limit_s. Without that key 0.1 s, or 0.02 s on a PREEMPT_RT kernel.
[[nodiscard]] std::int64_t stall_limit_ns(const config::RealtimeOptions& options, const KernelFacts& kernel);

/// Prepares the whole process for a real-time thread while this lives: memory locked, heap never given back, no
/// transparent huge pages, no deep CPU sleep. Records a refusal of the system instead of throwing. Not thread-safe.
class RealtimeProcess {
 public:
  explicit RealtimeProcess(RealtimeFacts& facts);
  RealtimeProcess(const RealtimeProcess&) = delete;
  RealtimeProcess& operator=(const RealtimeProcess&) = delete;
  ~RealtimeProcess();

 private:
  bool locked_ = false;
  os::FileDescriptor dma_latency_;  ///< prevents deep CPU sleep while it is open
};

/// Makes the calling thread a real-time one: CPU, SCHED_FIFO with at most kHighestLoopPriority, stack paged in.
/// Refusals of the system and a limited priority are recorded.
void enter_realtime(const config::RealtimeOptions& options, RealtimeFacts& facts);

}  // namespace eha::acquisition
