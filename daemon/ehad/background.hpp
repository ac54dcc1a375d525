// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "core/os/file_descriptor.hpp"
#include "daemon/control/event_loop.hpp"

namespace eha::service {

/// Carries calls from other threads to the main thread. post() is thread-safe; the rest belongs to the main thread.
///
/// Not sd-event: it would replace some 100 lines of EventLoop and Service, but its C callbacks cannot let an exception
/// through, it is not thread-safe (this queue and its event descriptor would stay), and it dispatches one source per
/// epoll_wait, which changes the fairness that the flood tests hold.
class Mailbox {
 public:
  explicit Mailbox(control::EventLoop& loop);
  Mailbox(const Mailbox&) = delete;
  Mailbox& operator=(const Mailbox&) = delete;
  ~Mailbox();

  void post(std::function<void()> message);

 private:
  void deliver();

  control::EventLoop& loop_;
  os::FileDescriptor descriptor_;
  std::mutex mutex_;
  std::deque<std::function<void()>> messages_;
};

/// A thread that runs one task after another, so that the main thread never waits for a disk, a device or a long
/// computation. It handles no signals. The public members belong to the main thread, except beats().
class Background {
 public:
  /// @param name  of the thread, at most 15 characters
  Background(const char* name, Mailbox& mailbox);
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;
  /// Returns when every task has run; results that are not delivered yet are dropped with the mailbox.
  ~Background();

  /// Runs `work` in the thread after all earlier tasks, then passes its outcome to `then` in the main thread.
  /// @param then  gets a std::future that is ready: get() returns what `work` returned, or throws what it threw
  template <typename Work, typename Then>
  void ask(Work work, Then then) {
    using Result = std::invoke_result_t<Work>;
    auto task = std::make_shared<std::packaged_task<Result()>>(std::move(work));
    auto answer = std::make_shared<Then>(std::move(then));
    push([this, task, answer] {
      (*task)();
      mailbox_.post([task, answer] { (*answer)(task->get_future()); });
    });
  }

  /// Makes the thread run `work` every `interval` while it has no task, at once for the first time. Call at most once.
  void when_idle(std::chrono::milliseconds interval, std::function<void()> work);

  /// Counts up at least five times a second while the thread has nothing to do. Thread-safe.
  [[nodiscard]] std::uint64_t beats() const noexcept { return beats_.load(std::memory_order_relaxed); }

 private:
  void push(std::function<void()> work);
  void run();

  Mailbox& mailbox_;
  std::atomic<std::uint64_t> beats_{0};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> work_;
  bool ending_ = false;
  std::function<void()> idle_work_;
  std::chrono::milliseconds idle_interval_{};
  std::thread thread_;
};

}  // namespace eha::service
