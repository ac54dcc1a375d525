// SPDX-License-Identifier: GPL-3.0-or-later
// eha-worker PARENT AVOIDED_CPU CPU_SECONDS MEMORY_BYTES NICE PROGRAM ARGUMENTS...: sets the limits that only the child
// itself can set, then becomes PROGRAM. ehad starts it; users do not.
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "core/error.hpp"

namespace {

constexpr int kFirstWord = 6;  // program in argv[6]

[[noreturn]] void fail(const char* what) {
  std::fprintf(stderr, "eha-worker: error: %s: %s\n", what, eha::error_text(errno).c_str());
  std::_Exit(static_cast<int>(eha::ExitCode::io));
}

/// Makes the OOM killer choose this process before the service.
void raise_oom_score() {
  std::FILE* const file = std::fopen("/proc/self/oom_score_adj", "we");
  if (file == nullptr) return;
  std::fputs("500", file);
  std::fclose(file);
}

/// Uses all CPUs but one. On a machine with one CPU only the scheduling policy keeps the worker out of the way.
void stay_off(long cpu) {
  cpu_set_t cpus;
  if (cpu < 0 || cpu >= CPU_SETSIZE || sched_getaffinity(0, sizeof cpus, &cpus) != 0) return;
  CPU_CLR(static_cast<std::size_t>(cpu), &cpus);
  if (CPU_COUNT(&cpus) > 0) sched_setaffinity(0, sizeof cpus, &cpus);
}

/// Sets a limit, or keeps a lower one of the service itself, which only root could raise.
/// @param spare  by which the hard limit, which kills, is beyond the soft one
void limit(__rlimit_resource resource, rlim_t soft, rlim_t spare) {
  rlimit limits{};
  if (getrlimit(resource, &limits) != 0) fail("getrlimit");
  limits.rlim_max = std::min(limits.rlim_max, soft + spare);
  limits.rlim_cur = limits.rlim_max - std::min(limits.rlim_max, spare);
  if (setrlimit(resource, &limits) != 0) fail("setrlimit");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc <= kFirstWord) {
    std::fputs("eha-worker: error: to be started by ehad only; see eha fit\n", stderr);
    return static_cast<int>(eha::ExitCode::usage);
  }
  if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) fail("prctl");
  // The parent may have died before prctl.
  if (getppid() != static_cast<pid_t>(std::atol(argv[1]))) return static_cast<int>(eha::ExitCode::interrupted);
  raise_oom_score();
  stay_off(std::atol(argv[2]));
  // An ehad that was started at a lower priority may not raise its worker's above its own.
  const int nice = std::max(static_cast<int>(std::strtol(argv[5], nullptr, 10)), getpriority(PRIO_PROCESS, 0));
  if (setpriority(PRIO_PROCESS, 0, nice) != 0) fail("setpriority");
  const sched_param none{};
  if (sched_setscheduler(0, SCHED_BATCH, &none) != 0) fail("sched_setscheduler");
  const auto cpu_s = static_cast<rlim_t>(std::strtoull(argv[3], nullptr, 10));
  limit(RLIMIT_CPU, cpu_s, 1);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // A sanitizer's shadow takes terabytes of addresses.
  const auto memory = static_cast<rlim_t>(std::strtoull(argv[4], nullptr, 10));
  limit(RLIMIT_AS, memory, 0);
#endif
  limit(RLIMIT_CORE, 0, 0);
  execv(argv[kFirstWord], argv + kFirstWord);
  fail(argv[kFirstWord]);
}
