// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "daemon/acquisition/clock.hpp"

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
  static std::chrono::nanoseconds difference() {
    acquisition::MonotonicClock clock;
    // In this order a wait between the two lowers the difference and is never taken for a suspend.
    const std::int64_t with_suspends_ns = clock.with_suspends_ns();
    return std::chrono::nanoseconds(with_suspends_ns - clock.now_ns());
  }

  std::optional<std::chrono::nanoseconds> last_;
};

}  // namespace eha::service
