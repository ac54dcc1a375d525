// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <thread>
#include <vector>

namespace eha::doctor {

/// Keeps every CPU that this process may use busy at ordinary priority while it lives. Each thread computes and copies
/// more memory than the caches hold. Not thread-safe.
class LoadThreads {
 public:
  /// Returns once every thread has touched its memory.
  LoadThreads();
  LoadThreads(const LoadThreads&) = delete;
  LoadThreads& operator=(const LoadThreads&) = delete;
  ~LoadThreads();

 private:
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

}  // namespace eha::doctor
