// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "daemon/play/run_watch.hpp"

namespace eha::service {

/// Decides whether to feed the watchdog: the loop (its ticks; between runs the idle beats of the rig's thread) and the
/// writer must make progress. The call itself proves the main thread's progress. Not thread-safe.
class Health {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds kLoopPatience{2};
  /// Between runs, while a card that refuses the safe voltage is opened and closed: its guard has 12 s, and a dozen
  /// calls to the card up to 1 s each.
  static constexpr std::chrono::seconds kUnsafePatience{30};
  static constexpr std::chrono::seconds kWriterPatience{10};

  /// @param watch  of the present run; none between runs
  /// @param idle_beats  of the rig's thread
  /// @param loop_patience  with the loop; kUnsafePatience for a card that has not confirmed the safe voltage
  /// @returns empty if all make progress, otherwise the part that does not
  [[nodiscard]] std::string check(const play::RunWatch* watch, std::uint64_t idle_beats, Clock::time_point now,
                                  std::chrono::seconds loop_patience = kLoopPatience) {
    using Phase = play::RunWatch::Phase;
    const Phase phase = watch != nullptr ? watch->phase.load() : Phase::preparing;
    // The time to write the files grows with the record; nothing is driven then.
    const bool loop_is_watched = watch == nullptr || phase == Phase::playing;
    const bool writer_is_watched = watch != nullptr && (phase == Phase::playing || phase == Phase::draining);
    const std::uint64_t loop_count = watch == nullptr ? idle_beats : watch->board.read().sequence;
    const std::uint64_t writer_count = watch == nullptr ? 0 : watch->writer_turns.load();
    if (!loop_is_watched || loop_.has_moved(watch, loop_count)) loop_.at = now;
    if (!writer_is_watched || writer_.has_moved(watch, writer_count)) writer_.at = now;
    if (now - loop_.at > loop_patience) return "the loop stands still";
    if (now - writer_.at > kWriterPatience) return "the writer of the record stands still";
    return {};
  }

 private:
  struct Progress {
    const play::RunWatch* run = nullptr;
    std::uint64_t count = 0;
    Clock::time_point at = Clock::now();

    bool has_moved(const play::RunWatch* of, std::uint64_t value) {
      const bool moved = of != run || value != count;
      run = of;
      count = value;
      return moved;
    }
  };

  Progress loop_;
  Progress writer_;
};

}  // namespace eha::service
