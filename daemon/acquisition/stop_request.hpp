// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>

namespace eha::acquisition {

/// Asks a running loop to stop: the first request ramps out, the second makes safe at once. Every member may be called
/// from any thread and from a signal handler. Real-time safe.
class StopRequest {
 public:
  void request() noexcept { count_.fetch_add(1, std::memory_order_relaxed); }
  /// Asks for a ramp-out; does nothing after an earlier request, so that it never counts as the second one.
  void request_ramp_out() noexcept {
    int none = 0;
    count_.compare_exchange_strong(none, 1, std::memory_order_relaxed);
  }
  [[nodiscard]] int count() const noexcept { return count_.load(std::memory_order_relaxed); }

  /// Called by a fatal-signal handler before it writes the safe command itself; the loop then stops writing.
  void take_over_outputs() noexcept { outputs_taken_.store(true, std::memory_order_release); }
  [[nodiscard]] bool outputs_taken() const noexcept { return outputs_taken_.load(std::memory_order_acquire); }

 private:
  std::atomic<int> count_{0};
  std::atomic<bool> outputs_taken_{false};
  static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);
};

}  // namespace eha::acquisition
