// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/realtime.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>

#include "core/error.hpp"
#include "core/os/memory.hpp"
#include "core/priorities.hpp"

namespace eha::acquisition {
namespace {

// Measured on an ordinary kernel under load: 1 false alarm in 180 s at 0.05 s, on a virtual machine that loses its
// processors for up to 0.101 s at a time.
constexpr double kStallLimit_s = 0.1;
constexpr double kStallLimitPreemptRt_s = 0.02;

constexpr std::size_t kPrefaultedStack = 128 * 1024;

/// Under a finite limit an unprivileged process could lock its present memory and then fail to allocate more.
bool may_lock_everything() {
  rlimit limit{};
  return geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
}

/// Touches the pages below the present end of the stack, so that they are there when a tick needs them.
[[gnu::noinline]] void prefault_stack() {
  std::array<volatile std::byte, kPrefaultedStack> pages;
  for (std::size_t i = 0; i < pages.size(); i += 1024) pages[i] = std::byte{0};
}

}  // namespace

KernelFacts kernel_facts() {
  KernelFacts facts;
  utsname names{};
  if (uname(&names) == 0) {
    facts.release = names.release;
    facts.version = names.version;
  }
  std::ifstream flag("/sys/kernel/realtime");
  int value = 0;
  facts.preempt_rt = (flag >> value && value == 1) || facts.version.find("PREEMPT_RT") != std::string::npos ||
                     facts.version.find("PREEMPT RT") != std::string::npos;
  return facts;
}

std::int64_t stall_limit_ns(const config::RealtimeOptions& options, const KernelFacts& kernel) {
  const double limit_s = options.stall_limit_s.value_or(kernel.preempt_rt ? kStallLimitPreemptRt_s : kStallLimit_s);
  return std::llround((options.sample_period_s + limit_s) * 1e9);
}

RealtimeProcess::RealtimeProcess(RealtimeFacts& facts) {
  prctl(PR_SET_THP_DISABLE, 1, 0, 0, 0);
  if (!may_lock_everything()) {
    facts.refused.emplace_back(
        "memory is not locked: the limit on locked memory is finite; set LimitMEMLOCK=infinity, or memlock unlimited "
        "in /etc/security/limits.d");
  } else if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    facts.refused.push_back("memory is not locked: " + error_text(errno));
  } else {
    locked_ = true;
    os::keep_freed_memory();
  }
  facts.memory_locked = locked_;
  dma_latency_ = os::FileDescriptor(open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC));
  const std::int32_t latency_us = 0;
  facts.c_states_held = dma_latency_ && write(dma_latency_.get(), &latency_us, sizeof latency_us) ==
                                            static_cast<ssize_t>(sizeof latency_us);
  if (!facts.c_states_held) {
    facts.refused.push_back("deep CPU sleep is not held off: /dev/cpu_dma_latency: " + error_text(errno));
  }
}

RealtimeProcess::~RealtimeProcess() {
  if (locked_) {
    munlockall();
    os::return_freed_memory();
  }
  prctl(PR_SET_THP_DISABLE, 0, 0, 0, 0);
}

void enter_realtime(const config::RealtimeOptions& options, RealtimeFacts& facts) {
  if (options.cpu) {
    cpu_set_t cpus;
    CPU_ZERO(&cpus);
    const bool exists = *options.cpu >= 0 && *options.cpu < CPU_SETSIZE;
    if (exists) CPU_SET(static_cast<std::size_t>(*options.cpu), &cpus);
    const int error = exists ? pthread_setaffinity_np(pthread_self(), sizeof cpus, &cpus) : EINVAL;
    facts.cpu_bound = error == 0;
    if (error != 0) {
      facts.refused.push_back("the loop is not bound to CPU " + std::to_string(*options.cpu) + ": " +
                              error_text(error));
    }
  }
  sched_param parameter{};
  const int priority = std::min(options.priority, kHighestLoopPriority);
  if (priority < options.priority) {
    facts.refused.push_back("realtime.priority = " + std::to_string(options.priority) + " is limited to " +
                            std::to_string(priority) + ": the guard runs at " + std::to_string(kGuardPriority) +
                            " and must be able to preempt the loop; set at most " + std::to_string(priority));
  }
  parameter.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter);
  facts.fifo = error == 0;
  if (error != 0) {
    facts.refused.push_back("SCHED_FIFO " + std::to_string(priority) + " is refused: " + error_text(error) +
                            "; set LimitRTPRIO, or rtprio in /etc/security/limits.d");
  }
  prefault_stack();
}

}  // namespace eha::acquisition
