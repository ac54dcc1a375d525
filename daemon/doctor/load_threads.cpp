// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/load_threads.hpp"

#include <signal.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <latch>

#include "core/os/processors.hpp"

namespace eha::doctor {
namespace {

constexpr std::size_t kWords = 4U << 20U;  // 32 MiB to read, 32 MiB to write

void block_signals() {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
}

}  // namespace

LoadThreads::LoadThreads() {
  const auto count = static_cast<std::ptrdiff_t>(os::usable_processors());
  std::latch ready(count);
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    threads_.emplace_back([this, &ready] {
      block_signals();
      std::vector<std::uint64_t> from(kWords, 1);
      std::vector<std::uint64_t> to(kWords);
      ready.count_down();
      while (!stop_.load(std::memory_order_relaxed)) {
        // A step of Marsaglia's xorshift, so that the copy needs arithmetic and cannot be optimised away.
        std::transform(from.begin(), from.end(), to.begin(), [](std::uint64_t x) {
          x ^= x << 13U;
          x ^= x >> 7U;
          return x ^ (x << 17U);
        });
        std::swap(from, to);
      }
    });
  }
  ready.wait();
}

LoadThreads::~LoadThreads() {
  stop_.store(true, std::memory_order_relaxed);
  for (std::thread& thread : threads_) thread.join();
}

}  // namespace eha::doctor
