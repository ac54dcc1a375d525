// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <thread>

#include "daemon/acquisition/clock.hpp"
#include "daemon/acquisition/record_queue.hpp"
#include "daemon/play/run_watch.hpp"
#include "daemon/record/journal.hpp"

namespace eha::play {

/// Longest time that a disk may hang; then the command is ramped out and the run has failed. On the monotonic clock
/// only.
inline constexpr std::chrono::seconds kWriterPatience{6};

/// The thread that moves records from the loop's queue to the journal until the loop has ended. After a failure it
/// drops records and has the queue report it to the loop, which ramps out. The public members belong to one thread.
class JournalThread {
 public:
  /// @param watch  its writer_turns counts the passes of the thread's loop
  JournalThread(acquisition::RecordQueue& queue, record::JournalWriter& journal, acquisition::TimeBase time_base,
                RunWatch& watch);
  JournalThread(const JournalThread&) = delete;
  JournalThread& operator=(const JournalThread&) = delete;
  ~JournalThread() { finish(); }

  /// Whether the thread has hung in one call for longer than kWriterPatience. Call several times a second.
  [[nodiscard]] bool hangs();

  /// Writes the rest of the queue and ends the thread. Call after the loop has pushed its last record.
  /// @returns the message of a failed write, or nothing
  std::string finish();

 private:
  void run();
  void write(std::size_t count);

  acquisition::RecordQueue& queue_;
  record::JournalWriter& journal_;
  acquisition::TimeBase time_base_;
  RunWatch& watch_;
  std::uint64_t turns_seen_ = 0;
  std::chrono::steady_clock::time_point turned_ = std::chrono::steady_clock::now();
  std::vector<acquisition::TickRecord> batch_;
  std::chrono::steady_clock::time_point synchronised_ = std::chrono::steady_clock::now();
  std::string error_;
  std::atomic<bool> loop_ended_{false};
  std::thread thread_;
};

}  // namespace eha::play
