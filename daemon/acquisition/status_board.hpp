// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "daemon/acquisition/tick_record.hpp"

namespace eha::acquisition {

/// Counters of a loop.
struct LoopCounters {
  std::uint64_t ticks = 0;            ///< ticks that ran
  std::uint64_t experiment_rows = 0;  ///< rows in state running, skipped ones included
  std::uint64_t late = 0;             ///< ticks that started more than half a period late
  std::uint64_t skipped = 0;          ///< grid ticks that never ran
  std::uint64_t skipped_rows = 0;     ///< of `experiment_rows`, those of such ticks
  std::uint64_t timeouts = 0;         ///< reads and writes that timed out and were held
  std::uint64_t clamped = 0;          ///< commands cut to the rig's range
  std::uint64_t slew_limited = 0;     ///< commands slowed to the rig's slew limit
  std::uint64_t dropped = 0;          ///< records lost because the queue was full
  std::uint64_t queue_peak = 0;       ///< greatest fill of the queue [records]
  std::int64_t minor_faults = 0;      ///< of the loop's thread since its first tick
  std::int64_t major_faults = 0;
  std::int64_t involuntary_switches = 0;
};

/// A consistent view of a running loop.
struct Snapshot {
  State state = State::faulted;
  Fault fault = Fault::none;
  std::uint32_t sequence = 0;
  std::uint32_t experiment_row = 0;  ///< rows played, of `experiment_rows`
  std::uint32_t experiment_rows = 0;
  std::int64_t elapsed_ns = 0;  ///< from the run's first tick [ns]
  double requested_V = 0.0;
  double applied_V = 0.0;
  double displacement_in = 0.0;
  double velocity_in_per_s = 0.0;
  double travel_share = 0.0;    ///< of the way from mid-travel to a travel limit; see LimitMonitor
  double velocity_share = 0.0;  ///< of the velocity limit
  std::uint32_t feedback_code = 0;
  std::uint32_t digital_inputs = 0;
  std::uint16_t flags = 0;      ///< TickFlag bits of the last row
  bool enable_contact = false;  ///< as read last
  std::int64_t latency_max_ns = 0;
  std::int64_t execution_max_ns = 0;
  LoopCounters counters;
};

/// Share of the experiment's rows so far that skipped ticks have lost [%].
[[nodiscard]] inline double lost_percent(const Snapshot& now) noexcept {
  return now.experiment_row == 0
             ? 0.0
             : 100.0 * static_cast<double>(now.counters.skipped_rows) / static_cast<double>(now.experiment_row);
}

/// Holds the latest Snapshot, written by the loop and read by any thread; neither waits for the other (a sequence
/// lock). Real-time safe on the writing side (one writer). Reading is thread-safe and retries while a write is under
/// way. Boehm, "Can seqlocks get along with programming language memory models?", MSPC 2012.
class StatusBoard {
 public:
  void publish(const Snapshot& snapshot) noexcept {
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), static_cast<const void*>(&snapshot), sizeof snapshot);
    const std::uint64_t version = version_.load(std::memory_order_relaxed);
    version_.store(version + 1, std::memory_order_relaxed);
    // Release: a thread that reads one of these words also sees the odd version.
    for (std::size_t i = 0; i < kWords; ++i) words_[i].store(words[i], std::memory_order_release);
    version_.store(version + 2, std::memory_order_release);
  }

  [[nodiscard]] Snapshot read() const noexcept {
    std::array<std::uint64_t, kWords> words{};
    for (;;) {
      const std::uint64_t before = version_.load(std::memory_order_acquire);
      for (std::size_t i = 0; i < kWords; ++i) words[i] = words_[i].load(std::memory_order_acquire);
      if (before % 2 == 0 && before == version_.load(std::memory_order_relaxed)) break;
    }
    Snapshot snapshot;
    std::memcpy(static_cast<void*>(&snapshot), words.data(), sizeof snapshot);
    return snapshot;
  }

 private:
  static constexpr std::size_t kWords = (sizeof(Snapshot) + 7) / 8;
  static_assert(std::is_trivially_copyable_v<Snapshot>);
  std::atomic<std::uint64_t> version_{0};
  std::array<std::atomic<std::uint64_t>, kWords> words_{};
};

}  // namespace eha::acquisition
