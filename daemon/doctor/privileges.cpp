// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/privileges.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <thread>

#include "core/os/file_descriptor.hpp"

namespace eha::doctor {
namespace {

template <typename Resource>
std::uint64_t limit_of(Resource resource) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0) return 0;
  return limit.rlim_cur == RLIM_INFINITY ? Privileges::kUnlimited : limit.rlim_cur;
}

}  // namespace

Privileges probe_privileges(int priority) {
  Privileges found;
  found.is_root = geteuid() == 0;
  std::thread([&] {
    sched_param parameter{};
    parameter.sched_priority = priority;
    found.fifo_error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter);
  }).join();
  found.rtprio_limit = limit_of(RLIMIT_RTPRIO);
  found.memlock_limit_bytes = limit_of(RLIMIT_MEMLOCK);
  const os::FileDescriptor dma_latency(open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC));
  found.dma_latency_error = dma_latency ? 0 : errno;
  return found;
}

}  // namespace eha::doctor
