// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "daemon/web/daemon_feed.hpp"
#include "daemon/web/http.hpp"
#include "daemon/web/response_meter.hpp"
#include "daemon/web/run_store.hpp"
#include "daemon/web/stop_token.hpp"

namespace eha::web {

/// Serves the paths: the page, /api and the files of the runs. Thread-safe.
class Site {
 public:
  Site(RunStore& store, const DaemonFeed& feed, ResponseMeter& meter, StopToken& token, std::filesystem::path socket);

  /// Answers a request that AccessRules accepted. Every answer has a content policy and says whether it may be cached.
  /// @param user  of the request; kUnknownUser: unknown
  void answer(const httplib::Request& request, httplib::Response& response, uid_t user);

 private:
  void answer_api(const httplib::Request& request, httplib::Response& response);
  void answer_run(const std::string& path, httplib::Response& response) const;
  /// Whether the request has the token; otherwise sets the answer to the refusal.
  bool has_token(const httplib::Request& request, httplib::Response& response, uid_t user);
  /// Allows a user to find a mistyped token before it is needed. Tries count like those of stop().
  void check_token(const httplib::Request& request, httplib::Response& response, uid_t user);
  /// Answers within kPatience, so that a hanging ehad holds no thread for longer.
  void stop(const httplib::Request& request, httplib::Response& response, uid_t user);
  /// The list of the newest runs as text, listed at most once a second by one thread at a time.
  [[nodiscard]] std::string runs(std::size_t most);

  RunStore& store_;
  const DaemonFeed& feed_;
  ResponseMeter& meter_;
  StopToken& token_;
  std::filesystem::path socket_;
  std::mutex listing_;                                    ///< held while the folder is read
  std::mutex runs_mutex_;                                 ///< guards the following members
  std::shared_ptr<const std::vector<std::string>> runs_;  ///< one text a run, newest first
  std::chrono::steady_clock::time_point runs_listed_{};
};

}  // namespace eha::web
