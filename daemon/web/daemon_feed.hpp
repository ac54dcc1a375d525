// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "daemon/web/live_blocks.hpp"

namespace eha::web {

/// Latest status of ehad for any number of readers: one thread follows `watch` over one connection and reconnects after
/// ehad has ended. Thread-safe.
class DaemonFeed {
 public:
  using Json = nlohmann::ordered_json;
  /// Called in the feed's thread with the folder of the runs after each connection to ehad.
  using OnRuns = std::function<void(const std::filesystem::path&)>;

  /// @param on_runs  none: ehad is not asked for the folder
  DaemonFeed(std::filesystem::path socket, OnRuns on_runs);
  DaemonFeed(const DaemonFeed&) = delete;
  DaemonFeed& operator=(const DaemonFeed&) = delete;
  /// Waits for the thread: some 100 ms, longer if ehad does not answer.
  ~DaemonFeed();

  /// {daemon, status, units, limits, queue, version} as text, at most 0.1 s old. Cost: a pointer.
  [[nodiscard]] std::shared_ptr<const std::string> state() const;

  /// {first, next, dropped, run, now_ns, blocks} as text; see LiveBlocks.
  [[nodiscard]] std::string live(std::int64_t since) const;

  /// The run being played.
  struct Run {
    std::string id;             ///< name of its folder; empty: none
    double experiment_s = 0.0;  ///< played part of the run [s]
  };
  [[nodiscard]] Run run() const;

 private:
  void follow();
  void follow_once();
  void take(const Json& status, const Json& queue);
  void lose(const std::string& why);

  std::filesystem::path socket_;
  OnRuns on_runs_;
  std::atomic<bool> stopping_{false};
  mutable std::mutex mutex_;  ///< guards the following members
  std::shared_ptr<const std::string> state_;
  std::chrono::steady_clock::time_point heard_{};
  std::shared_ptr<const std::string> lost_state_;
  std::shared_ptr<const std::string> silent_state_;
  LiveBlocks blocks_;
  Run run_;
  std::thread thread_;
};

}  // namespace eha::web
