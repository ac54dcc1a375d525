// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>

#include "daemon/acquisition/clock.hpp"
#include "daemon/acquisition/record_queue.hpp"
#include "daemon/play/run_watch.hpp"
#include "daemon/play/sample_stream.hpp"
#include "daemon/record/folder_watch.hpp"
#include "daemon/record/journal.hpp"

namespace eha::play {

/// Longest time that a disk may hang; then the command is ramped out and the run has failed. On the monotonic clock
/// only.
inline constexpr std::chrono::seconds kWriterPatience{6};

/// Interval of the run folder's checks: a deleted one is noticed within this time and a call on the disk.
inline constexpr std::chrono::milliseconds kFolderInterval{250};

/// Thread that moves records from the loop's queue to the journal until the loop has ended. After a failed write it
/// keeps the records and tries again until then; if the disk is nearly full, or the run folder is deleted or takes no
/// files, it continues to write. In each case the queue reports it to the loop, which ramps out. The public members
/// belong to one thread.
class JournalThread {
 public:
  /// @param watch  its writer_turns counts the passes of the thread's loop; its samples get the records, also after a
  ///               failed write
  JournalThread(acquisition::RecordQueue& queue, record::JournalWriter& journal, const record::FolderWatch& folder,
                acquisition::TimeBase time_base, RunWatch& watch);
  JournalThread(const JournalThread&) = delete;
  JournalThread& operator=(const JournalThread&) = delete;
  ~JournalThread() { finish(); }

  /// Whether the thread has hung in one call for longer than kWriterPatience. Call several times a second.
  [[nodiscard]] bool hangs();

  /// Writes the rest of the queue and ends the thread. Call after the loop has pushed its last record.
  /// @returns the message of a failed write, a full disk or a lost folder, or nothing
  std::string finish();

  /// After finish(): whether the journal has every row.
  [[nodiscard]] bool journal_is_sound() const noexcept { return is_written_ && is_synchronised_; }

 private:
  void run();
  void write(std::size_t count);
  void show(std::size_t count);
  /// Has the rows up to the first fault on the disk at once: after a kill they say what must precede the next arming.
  void keep_fault(std::size_t count);
  void synchronise();
  void keep_room();
  void look_at_folder();
  void fail(std::string message);

  acquisition::RecordQueue& queue_;
  record::JournalWriter& journal_;
  const record::FolderWatch& folder_;
  acquisition::TimeBase time_base_;
  RunWatch& watch_;
  std::optional<BlockMaker> blocks_;
  std::uint64_t turns_seen_ = 0;
  std::chrono::steady_clock::time_point turned_ = std::chrono::steady_clock::now();
  std::vector<acquisition::TickRecord> batch_;
  std::chrono::steady_clock::time_point synchronised_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point looked_ = std::chrono::steady_clock::now();
  std::uint64_t played_ = 0;  ///< rows of the experiment that were appended
  bool is_written_ = true;    ///< every full block
  bool is_synchronised_ = true;
  bool has_fault_ = false;   ///< of the run, written
  std::string write_error_;  ///< of the journal; what it led to is known at the end
  std::string room_error_;   ///< no room for more rows than will come
  std::string error_;
  std::atomic<bool> loop_ended_{false};
  std::thread thread_;
};

}  // namespace eha::play
