// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/control/event_loop.hpp"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

#include "core/error.hpp"

namespace eha::control {
namespace {

[[noreturn]] void fail(int error_number) { throw IoError("cannot wait for events: " + error_text(error_number)); }

}  // namespace

EventLoop::EventLoop() : epoll_(epoll_create1(EPOLL_CLOEXEC)) {
  if (!epoll_) fail(errno);
}

void EventLoop::control(int operation, int descriptor, std::uint32_t events, std::uint64_t token) {
  epoll_event event{};
  event.events = events;
  event.data.u64 = token;
  if (epoll_ctl(epoll_.get(), operation, descriptor, &event) != 0) fail(errno);
}

void EventLoop::add(int descriptor, std::uint32_t events, Handler handler) {
  const std::uint64_t token = next_token_++;
  control(EPOLL_CTL_ADD, descriptor, events, token);
  entries_[descriptor] = {token, std::make_shared<Handler>(std::move(handler))};
  descriptors_[token] = descriptor;
}

void EventLoop::change(int descriptor, std::uint32_t events) {
  control(EPOLL_CTL_MOD, descriptor, events, entries_.at(descriptor).token);
}

void EventLoop::remove(int descriptor) {
  const auto found = entries_.find(descriptor);
  if (found == entries_.end()) return;
  control(EPOLL_CTL_DEL, descriptor, 0, 0);
  descriptors_.erase(found->second.token);
  entries_.erase(found);
}

void EventLoop::run_once(std::chrono::milliseconds timeout) {
  std::array<epoll_event, 64> events;
  const int count =
      epoll_wait(epoll_.get(), events.data(), static_cast<int>(events.size()), static_cast<int>(timeout.count()));
  if (count < 0 && errno != EINTR) fail(errno);
  for (int i = 0; i < count; ++i) {
    const epoll_event& event = events[static_cast<std::size_t>(i)];
    const auto descriptor = descriptors_.find(event.data.u64);
    if (descriptor == descriptors_.end()) continue;
    const std::shared_ptr<Handler> handler = entries_.at(descriptor->second).handler;
    (*handler)(event.events);
  }
}

}  // namespace eha::control
