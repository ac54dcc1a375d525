// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>

#include "daemon/control/event_loop.hpp"
#include "daemon/control/server.hpp"
#include "daemon/ehad/notify.hpp"
#include "daemon/ehad/options.hpp"
#include "daemon/ehad/supervisor.hpp"

namespace eha::service {

/// The whole program: signals, socket, service manager, and the supervisor that they all speak to. Belongs to the main
/// thread.
class Service {
 public:
  /// Takes the rig and opens the socket; the signals that ehad knows are blocked in this thread and those it starts.
  /// @throws ConfigError, DeviceError, PermissionError, IoError
  explicit Service(const Options& options);
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;
  ~Service();

  /// Serves until SIGTERM or SIGINT, and until what they stopped is over.
  void run();

 private:
  using Clock = std::chrono::steady_clock;

  /// A client that wants to be told again and again.
  struct Watcher {
    std::int64_t id = 0;  ///< of the request
    std::chrono::nanoseconds interval{};
    Clock::time_point due;
    std::optional<EntryId> entry;
  };

  void on_signal();
  void on_request(const control::Peer& peer, const control::Request& request);
  void dispatch(const control::Peer& peer, const control::Request& request);
  void watch(const control::Peer& peer, std::int64_t id, const control::WatchCall& call);
  void answer(control::ClientId client, std::int64_t id, const std::function<Json()>& result);
  void feed_watchers(Clock::time_point now);
  [[nodiscard]] std::chrono::milliseconds patience(Clock::time_point now) const;

  control::EventLoop loop_;
  Notifier notifier_;
  int signals_;
  Supervisor supervisor_;
  std::map<control::ClientId, Watcher> watchers_;
  Clock::time_point next_turn_ = Clock::now();
  Clock::time_point next_sweep_ = Clock::now();
  control::Server server_;
};

}  // namespace eha::service
