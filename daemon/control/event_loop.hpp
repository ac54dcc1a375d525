// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/epoll.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <unordered_map>

namespace eha::control {

/// Waits for file descriptors and calls what was registered for those that are ready (epoll, level-triggered). A
/// handler may add, change and remove descriptors, its own too. Not thread-safe: belongs to one thread.
class EventLoop {
 public:
  using Handler = std::function<void(std::uint32_t events)>;

  /// @throws IoError
  EventLoop();
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;
  ~EventLoop();

  /// @param events  EPOLLIN, EPOLLOUT; @throws IoError
  void add(int descriptor, std::uint32_t events, Handler handler);
  void change(int descriptor, std::uint32_t events);
  /// Before the descriptor is closed.
  void remove(int descriptor);

  /// Waits for at most `patience` and serves what is ready, each descriptor once.
  void run_once(std::chrono::milliseconds patience);

 private:
  struct Entry {
    std::uint64_t token = 0;  ///< of this registration: an event that was under way for an earlier one is not for it
    std::shared_ptr<Handler> handler;
  };

  void control(int operation, int descriptor, std::uint32_t events, std::uint64_t token);

  int epoll_ = -1;
  std::uint64_t next_token_ = 1;
  std::unordered_map<int, Entry> entries_;
  std::unordered_map<std::uint64_t, int> descriptors_;
};

}  // namespace eha::control
