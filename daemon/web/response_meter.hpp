// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "daemon/web/daemon_feed.hpp"
#include "daemon/web/live_response.hpp"
#include "daemon/web/run_store.hpp"

namespace eha::web {

/// Measures the response of the present run, otherwise of the last one, in one thread of the lowest priority: at most
/// once a second, only while somebody asks, and only if another period may be complete. Thread-safe.
class ResponseMeter {
 public:
  ResponseMeter(const RunStore& store, const DaemonFeed& feed);
  ResponseMeter(const ResponseMeter&) = delete;
  ResponseMeter& operator=(const ResponseMeter&) = delete;
  ~ResponseMeter();

  /// Returns the answer to /api/response; {"run": null} until a run is known. Does not wait.
  [[nodiscard]] std::shared_ptr<const std::string> ask();

 private:
  void work();
  void turn();
  void measure(const std::string& run, const RunFile& journal);
  void publish(std::string text);

  const RunStore& store_;
  const DaemonFeed& feed_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  std::chrono::steady_clock::time_point asked_{};
  std::shared_ptr<const std::string> text_;

  // Used by the thread only.
  std::string run_;  ///< that has been measured
  PeriodPlan plan_;
  LiveResponse response_;
  std::uint64_t next_size_ = 0;  ///< size of the journal at which another period may be complete [bytes]
  std::int64_t modified_ns_ = 0;
  std::thread thread_;
};

}  // namespace eha::web
