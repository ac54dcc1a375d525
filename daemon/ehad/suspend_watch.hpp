// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <ctime>
#include <optional>

namespace eha::service {

/// Detects that the machine was suspended: CLOCK_BOOTTIME counts the time of a suspend, CLOCK_MONOTONIC does not.
/// Not thread-safe.
class SuspendWatch {
 public:
  static constexpr std::chrono::milliseconds kShortest{100};  ///< longer than reading two clocks in turn

  /// @returns the time for which the machine was suspended since the last call, if it was
  [[nodiscard]] std::optional<std::chrono::duration<double>> check() { return check(difference()); }

  /// @param difference  CLOCK_BOOTTIME less CLOCK_MONOTONIC now
  [[nodiscard]] std::optional<std::chrono::duration<double>> check(std::chrono::nanoseconds difference) {
    const std::chrono::nanoseconds grown = difference - last_.value_or(difference);
    last_ = difference;
    if (grown < kShortest) return std::nullopt;
    return grown;
  }

 private:
  static std::chrono::nanoseconds now(clockid_t clock) {
    timespec time{};
    clock_gettime(clock, &time);
    return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
  }
  static std::chrono::nanoseconds difference() { return now(CLOCK_BOOTTIME) - now(CLOCK_MONOTONIC); }

  std::optional<std::chrono::nanoseconds> last_;
};

}  // namespace eha::service
