// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>

namespace eha::service {

/// Limits the log lines that one user's requests cause: kBurst at once, kPerSecond in the long run. Not thread-safe.
class AuditLimiter {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr double kBurst = 50.0;
  static constexpr double kPerSecond = 5.0;
  static constexpr std::size_t kMostUsers = 1024;

  /// Whether a line may be logged now. @returns none: not; else the number of lines left out since the last one
  [[nodiscard]] std::optional<std::size_t> take(uid_t uid, Clock::time_point now) {
    if (users_.size() >= kMostUsers && !users_.contains(uid)) users_.clear();
    User& user = users_.try_emplace(uid, User{kBurst, now, 0}).first->second;
    user.tokens = std::min(kBurst, user.tokens + kPerSecond * std::chrono::duration<double>(now - user.at).count());
    user.at = now;
    if (user.tokens < 1.0) {
      ++user.left_out;
      return std::nullopt;
    }
    user.tokens -= 1.0;
    return std::exchange(user.left_out, 0);
  }

 private:
  struct User {
    double tokens = kBurst;
    Clock::time_point at;
    std::size_t left_out = 0;
  };
  std::map<uid_t, User> users_;
};

}  // namespace eha::service
