// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/background.hpp"

#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <utility>

#include "core/error.hpp"
#include "daemon/acquisition/fatal_signals.hpp"

namespace eha::service {
namespace {

constexpr auto kBeat = std::chrono::milliseconds(200);

os::FileDescriptor open_eventfd() {
  os::FileDescriptor descriptor(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!descriptor) throw IoError("cannot create an event descriptor: " + error_text(errno));
  return descriptor;
}

}  // namespace

Mailbox::Mailbox(control::EventLoop& loop) : loop_(loop), descriptor_(open_eventfd()) {
  loop_.add(descriptor_.get(), EPOLLIN, [this](std::uint32_t) { deliver(); });
}

Mailbox::~Mailbox() { loop_.remove(descriptor_.get()); }

void Mailbox::post(std::function<void()> message) {
  {
    const std::lock_guard lock(mutex_);
    messages_.push_back(std::move(message));
  }
  // Fails only at the count's maximum; the main thread is awake then.
  static_cast<void>(eventfd_write(descriptor_.get(), 1));
}

void Mailbox::deliver() {
  eventfd_t count = 0;
  static_cast<void>(eventfd_read(descriptor_.get(), &count));
  std::deque<std::function<void()>> taken;
  {
    const std::lock_guard lock(mutex_);
    taken.swap(messages_);
  }
  for (const auto& message : taken) message();
}

Background::Background(const char* name, Mailbox& mailbox) : mailbox_(mailbox), thread_([this] { run(); }) {
  pthread_setname_np(thread_.native_handle(), name);
}

Background::~Background() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void Background::push(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    work_.push_back(std::move(work));
  }
  changed_.notify_one();
}

void Background::when_idle(std::chrono::milliseconds interval, std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    idle_interval_ = interval;
    idle_work_ = std::move(work);
  }
  changed_.notify_one();
}

void Background::run() {
  using Clock = std::chrono::steady_clock;
  acquisition::block_all_but_fatal_signals();
  std::unique_lock lock(mutex_);
  Clock::time_point idle_due = Clock::now();
  for (;;) {
    beats_.fetch_add(1, std::memory_order_relaxed);
    if (work_.empty()) {
      if (ending_) return;
      if (!idle_work_) {
        changed_.wait_for(lock, kBeat);
      } else if (Clock::now() < idle_due) {
        changed_.wait_until(lock, std::min(idle_due, Clock::now() + kBeat));
      } else {
        lock.unlock();
        idle_work_();
        lock.lock();
        idle_due = Clock::now() + idle_interval_;
      }
      continue;
    }
    const std::function<void()> work = std::move(work_.front());
    work_.pop_front();
    lock.unlock();
    work();
    lock.lock();
  }
}

}  // namespace eha::service
