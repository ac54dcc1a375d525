// SPDX-License-Identifier: GPL-3.0-or-later
// To be preloaded into ehad: counts what the thread named eha-loop allocates, releases and locks in its ticks, into the
// file that EHA_LOOP_TRAP names. A tick is what lies between two absolute sleeps; what follows the last one is none.
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/prctl.h>
#include <time.h>
#include <unistd.h>

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

thread_local bool is_loop = false;
thread_local long locks_in_tick = 0;
thread_local long allocations_in_tick = 0;

long ticks = 0;  // of the loop's thread alone
long locks = 0;
long allocations = 0;

template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

auto* const real_nanosleep = next<int(clockid_t, int, const timespec*, timespec*)>("clock_nanosleep");
auto* const real_lock = next<int(pthread_mutex_t*)>("pthread_mutex_lock");

int open_report() {
  const char* path = std::getenv("EHA_LOOP_TRAP");
  return path != nullptr ? open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0600) : -1;
}
const int report = open_report();

void end_tick() {
  ++ticks;
  locks += locks_in_tick;
  allocations += allocations_in_tick;
  locks_in_tick = 0;
  allocations_in_tick = 0;
  if (ticks % 100 != 0) return;
  char line[80];
  const int size = std::snprintf(line, sizeof line, "%010ld %010ld %010ld\n", ticks, locks, allocations);
  static_cast<void>(!pwrite(report, line, static_cast<std::size_t>(size), 0));
  // Formatting is ours, not the loop's.
  locks_in_tick = 0;
  allocations_in_tick = 0;
}

}  // namespace

extern "C" {
// NOLINTBEGIN(bugprone-reserved-identifier): glibc's names
void* __libc_malloc(std::size_t);
void __libc_free(void*);
// NOLINTEND(bugprone-reserved-identifier)

int clock_nanosleep(clockid_t clock, int flags, const timespec* request, timespec* rest) {
  if (is_loop) end_tick();
  if (!is_loop && flags == TIMER_ABSTIME) {
    char name[16] = {};
    prctl(PR_GET_NAME, name);
    is_loop = std::strcmp(name, "eha-loop") == 0;
    locks_in_tick = 0;
    allocations_in_tick = 0;
  }
  return real_nanosleep(clock, flags, request, rest);
}

int pthread_mutex_lock(pthread_mutex_t* mutex) {
  if (is_loop) ++locks_in_tick;
  return real_lock != nullptr ? real_lock(mutex) : 0;
}

void* malloc(std::size_t size) {
  if (is_loop) ++allocations_in_tick;
  return __libc_malloc(size);
}

void free(void* block) {
  if (is_loop) ++allocations_in_tick;
  __libc_free(block);
}
}
