// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/epoll.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <unordered_map>

#include "core/os/file_descriptor.hpp"

namespace eha::control {

/// Waits for file descriptors and calls the handlers of those that are ready (epoll, level-triggered). A handler may
/// add, change and remove descriptors, its own included. Not thread-safe: belongs to one thread.
class EventLoop {
 public:
  using Handler = std::function<void(std::uint32_t events)>;

  /// @throws IoError
  EventLoop();
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;

  /// @param events  EPOLLIN, EPOLLOUT; @throws IoError
  void add(int descriptor, std::uint32_t events, Handler handler);
  void change(int descriptor, std::uint32_t events);
  /// Call before the descriptor is closed.
  void remove(int descriptor);

  /// Waits for at most `timeout`, then calls the handler of each ready descriptor once.
  void run_once(std::chrono::milliseconds timeout);

 private:
  struct Entry {
    std::uint64_t token = 0;  ///< number of this registration, so that events of an earlier one are not delivered
    std::shared_ptr<Handler> handler;
  };

  void control(int operation, int descriptor, std::uint32_t events, std::uint64_t token);

  os::FileDescriptor epoll_;
  std::uint64_t next_token_ = 1;
  std::unordered_map<int, Entry> entries_;
  std::unordered_map<std::uint64_t, int> descriptors_;
};

}  // namespace eha::control
