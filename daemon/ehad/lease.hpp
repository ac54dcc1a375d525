// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>

namespace eha::service {

inline constexpr uid_t kRoot = 0;

/// The user who may arm, run experiments and disarm, and the end of that right. A fault or a stop does not end it,
/// because the holder may be at the rod. Only its expiry, a release by the holder, or root ends it. Not thread-safe.
class Lease {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::minutes kDuration{10};

  struct Holder {
    uid_t uid = 0;
    std::string user;
    std::chrono::system_clock::time_point since = std::chrono::system_clock::now();  ///< without a break
  };

  /// @returns the number of the grant, for take_back()
  std::uint64_t grant(Holder holder, Clock::time_point now) {
    if (is_held_by(holder.uid)) holder.since = holder_.since;
    holder_ = std::move(holder);
    is_held_ = true;
    ends_ = now + kDuration;
    return ++grants_;
  }
  void release() { is_held_ = false; }
  /// Undoes a grant, unless another one followed.
  void take_back(std::uint64_t grant) {
    if (grant == grants_) is_held_ = false;
  }

  /// Call when the holder has acted, and while a run of the holder is in progress or has just ended.
  void renew(Clock::time_point now) { ends_ = now + kDuration; }

  /// Returns nullptr if nobody holds it. Valid until the next grant.
  [[nodiscard]] const Holder* holder() const noexcept { return is_held_ ? &holder_ : nullptr; }
  [[nodiscard]] bool is_held_by(uid_t uid) const noexcept { return is_held_ && holder_.uid == uid; }
  [[nodiscard]] bool has_expired(Clock::time_point now) const noexcept { return is_held_ && now >= ends_; }
  [[nodiscard]] std::chrono::duration<double> remaining(Clock::time_point now) const noexcept { return ends_ - now; }

 private:
  bool is_held_ = false;
  std::uint64_t grants_ = 0;
  Holder holder_;
  Clock::time_point ends_;
};

}  // namespace eha::service
