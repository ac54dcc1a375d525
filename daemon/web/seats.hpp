// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <map>
#include <mutex>

namespace eha::web {

enum class Seat {
  none,   ///< the connection is refused
  any,    ///< every request is answered
  spare,  ///< only a POST is answered: it may be a stop
};

/// Limits the connections of each user, so that no user can prevent another one from using Stop. Thread-safe. Cost
/// O(log users).
class Seats {
 public:
  static constexpr std::size_t kOfOneUser = 64;
  static constexpr std::size_t kOfAll = 256;
  static constexpr std::size_t kSpareOfOneUser = 8;  ///< in addition to kOfOneUser
  static constexpr std::size_t kSpareOfAll = 64;     ///< in addition to kOfAll

  [[nodiscard]] Seat take(uid_t user) {
    const std::lock_guard lock(mutex_);
    Taken& own = of_[user];
    if (own.any < kOfOneUser && all_.any < kOfAll) {
      ++own.any, ++all_.any;
      return Seat::any;
    }
    if (own.spare < kSpareOfOneUser && all_.spare < kSpareOfAll) {
      ++own.spare, ++all_.spare;
      return Seat::spare;
    }
    return Seat::none;
  }

  /// @param seat  result of take(), not none
  void leave(uid_t user, Seat seat) {
    const std::lock_guard lock(mutex_);
    Taken& own = of_[user];
    (seat == Seat::any ? own.any : own.spare) -= 1;
    (seat == Seat::any ? all_.any : all_.spare) -= 1;
    if (own.any + own.spare == 0) of_.erase(user);
  }

 private:
  struct Taken {
    std::size_t any = 0;
    std::size_t spare = 0;
  };
  std::mutex mutex_;
  Taken all_;
  std::map<uid_t, Taken> of_;
};

}  // namespace eha::web
