// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace eha::acquisition {

inline constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

/// Clock of a run.
enum class TimeBase : std::uint8_t {
  monotonic,     ///< monotonic clock, one tick each sample period
  virtual_time,  ///< virtual time, as fast as the machine computes; only for rigs that allow it
};

/// Time source of the ticks. Real-time safe. Used by the loop's thread only.
class Clock {
 public:
  Clock() = default;
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;
  virtual ~Clock() = default;

  /// @returns time from an arbitrary origin [ns], never decreasing
  [[nodiscard]] virtual std::int64_t now_ns() noexcept = 0;

  /// @returns the same time and all time in which the machine was suspended [ns]; a clock that knows none counts none
  [[nodiscard]] virtual std::int64_t with_suspends_ns() noexcept { return now_ns(); }

  /// Sleeps until `deadline_ns`; returns at once if that has passed.
  virtual void sleep_until(std::int64_t deadline_ns) noexcept = 0;

  /// Whether time is virtual and waits for the program: no deadlines, no SCHED_FIFO, the loop waits for a slow writer.
  [[nodiscard]] virtual bool is_virtual() const noexcept = 0;
};

/// CLOCK_MONOTONIC with absolute sleeps; CLOCK_BOOTTIME is the same with the time of suspends.
class MonotonicClock final : public Clock {
 public:
  [[nodiscard]] std::int64_t now_ns() noexcept override;
  [[nodiscard]] std::int64_t with_suspends_ns() noexcept override;
  void sleep_until(std::int64_t deadline_ns) noexcept override;
  [[nodiscard]] bool is_virtual() const noexcept override { return false; }
};

/// Virtual time: a sleep only advances it, so a simulated run takes no longer than its arithmetic.
class VirtualClock final : public Clock {
 public:
  [[nodiscard]] std::int64_t now_ns() noexcept override { return now_ns_; }
  void sleep_until(std::int64_t deadline_ns) noexcept override {
    if (deadline_ns > now_ns_) now_ns_ = deadline_ns;
  }
  [[nodiscard]] bool is_virtual() const noexcept override { return true; }

  /// Advances time inside a tick, as a slow call would.
  void advance(std::int64_t duration_ns) noexcept { now_ns_ += duration_ns; }

 private:
  std::int64_t now_ns_ = 0;
};

}  // namespace eha::acquisition
