// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "core/os/file_descriptor.hpp"
#include "daemon/control/event_loop.hpp"
#include "daemon/control/server.hpp"
#include "daemon/ehad/audit_limiter.hpp"
#include "daemon/ehad/notify.hpp"
#include "daemon/ehad/service_options.hpp"
#include "daemon/ehad/supervisor.hpp"
#include "daemon/ehad/user_names.hpp"

namespace eha::service {

/// The whole program: passes signals, requests and time to the Supervisor. Belongs to the main thread.
class Service {
 public:
  /// Opens the rig and the socket; blocks the signals that ehad handles in this thread and in those it starts.
  /// @throws ConfigError, DeviceError, PermissionError, IoError
  explicit Service(const Options& options);
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;
  ~Service();

  /// Serves until SIGTERM or SIGINT, then until the run that they stopped is over.
  void run();

 private:
  using Clock = std::chrono::steady_clock;

  /// A client that gets the status repeatedly.
  struct Watcher {
    std::int64_t id = 0;  ///< of the request
    std::chrono::nanoseconds interval{};
    Clock::time_point due;
    std::optional<EntryId> entry;
    std::optional<std::uint64_t> next_block;  ///< of the samples; none: not requested
  };

  void on_signal();
  void reload_on_signal();
  void on_request(const control::Peer& peer, const control::Request& request);
  void dispatch(const control::Peer& peer, const control::Request& request);
  void watch(const control::Peer& peer, std::int64_t id, const control::WatchCall& call);
  void audit(const control::Peer& peer, const std::string& text);
  void answer(const control::Peer& peer, std::int64_t id, const std::function<void()>& respond);
  void feed_watchers(Clock::time_point now);
  [[nodiscard]] std::chrono::milliseconds time_to_next(Clock::time_point now) const;

  control::EventLoop loop_;
  Notifier notifier_;
  os::FileDescriptor signals_;
  Supervisor supervisor_;
  UserNames names_;
  AuditLimiter audit_;
  std::map<control::ClientId, Watcher> watchers_;
  Clock::time_point next_poll_ = Clock::now();
  Clock::time_point next_sweep_ = Clock::now();
  control::Server server_;
};

}  // namespace eha::service
