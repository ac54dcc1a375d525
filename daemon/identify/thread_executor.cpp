// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/thread_executor.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "core/os/processors.hpp"

namespace eha::identify {
namespace {

/// Data shared by the threads of one call.
struct Batch {
  Batch(std::size_t tasks, const std::function<void(std::size_t)>& work_on) : count(tasks), task(work_on) {}

  std::size_t count;
  const std::function<void(std::size_t)>& task;
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::size_t failed_index = 0;
  std::exception_ptr failure;

  void work() {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        task(i);
      } catch (...) {
        const std::scoped_lock lock(mutex);
        if (!failure || i < failed_index) {
          failure = std::current_exception();
          failed_index = i;
        }
        next = count;
      }
    }
  }
};

}  // namespace

ident::Executor thread_executor(unsigned threads) {
  return [threads](std::size_t count, const std::function<void(std::size_t)>& task) {
    Batch batch(count, task);
    {
      std::vector<std::jthread> others;
      const std::size_t wanted = std::min<std::size_t>(std::max(threads, 1U), count);
      // The calling thread works too.
      for (std::size_t i = 1; i < wanted; ++i) others.emplace_back([&batch] { batch.work(); });
      batch.work();
    }
    if (batch.failure) std::rethrow_exception(batch.failure);
  };
}

ident::Executor thread_executor() { return thread_executor(os::usable_processors()); }

}  // namespace eha::identify
