// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/acquisition/trap.hpp"

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cstddef>

namespace eha::acquisition {
namespace {

thread_local bool trap_set = false;
thread_local long allocations_seen = 0;
thread_local long locks_seen = 0;

[[maybe_unused]] void note_allocation() noexcept { allocations_seen += trap_set ? 1 : 0; }
[[maybe_unused]] void note_lock() noexcept { locks_seen += trap_set ? 1 : 0; }

}  // namespace

Trap::Trap() noexcept {
  allocations_seen = 0;
  locks_seen = 0;
  trap_set = true;
}

Trap::~Trap() { trap_set = false; }

long Trap::allocations() noexcept { return allocations_seen; }
long Trap::locks() noexcept { return locks_seen; }

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
bool Trap::works() noexcept { return false; }
#else
bool Trap::works() noexcept { return true; }
#endif

}  // namespace eha::acquisition

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// glibc keeps its own functions reachable under these names.
extern "C" {
// NOLINTBEGIN(bugprone-reserved-identifier): glibc's names
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);
// NOLINTEND(bugprone-reserved-identifier)

void* malloc(std::size_t size) {
  eha::acquisition::note_allocation();
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  eha::acquisition::note_allocation();
  return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
  eha::acquisition::note_allocation();
  return __libc_realloc(block, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  eha::acquisition::note_allocation();
  return __libc_memalign(alignment, size);
}
void free(void* block) {
  eha::acquisition::note_allocation();
  __libc_free(block);
}
int pthread_mutex_lock(pthread_mutex_t* mutex) {
  eha::acquisition::note_lock();
  // Resolved on the first call, which comes long before any trap; two threads would store the same address.
  using Lock = int (*)(pthread_mutex_t*);
  static std::atomic<Lock> next{nullptr};
  Lock lock = next.load();
  if (lock == nullptr) {
    lock = reinterpret_cast<Lock>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
    next.store(lock);
  }
  return lock(mutex);
}
}
#endif
