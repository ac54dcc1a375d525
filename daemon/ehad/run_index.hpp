// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace eha::service {

inline constexpr double kBytesPerGiB = 1024.0 * 1024.0 * 1024.0;

/// Facts about a run, stored so that its folder need not be read.
struct IndexedRun {
  std::int64_t sequence = 0;  ///< in the order of the runs' starts, from 1; unlike the clock it cannot be wrong
  uid_t owner = 0;            ///< who submitted it; root if that is unknown
  std::string outcome;        ///< as in the manifest; in_progress until the run is over
  bool accepted = false;      ///< a model was accepted
  bool acknowledged = false;  ///< its incident was acknowledged (eha runs ack)
  std::uint64_t bytes = 0;    ///< of its files

  /// Whether it did not complete: faulted, interrupted, deadline, write_failed, recovered.
  [[nodiscard]] bool is_incident() const;
  /// Whether retention may remove it, regardless of its age.
  [[nodiscard]] bool may_go() const;
};

/// A removed run.
struct RemovedRun {
  std::string name;
  std::uint64_t bytes = 0;
};

/// Result of RunIndex::keep_within().
struct Retention {
  std::vector<RemovedRun> removed;
  std::uint64_t bytes = 0;  ///< size of the remaining runs
  std::string refusal;      ///< reason for which the next run must not begin; empty within the budget
};

/// Index of the service's run folders: makes the cost of a run independent of the number of kept runs. Stored in a file
/// of JSON lines, one appended for each change, the last line of a run valid; rewritten at the start. Facts missing
/// from the file are read from the folders. Blocks on the disk. Not thread-safe.
class RunIndex {
 public:
  static constexpr std::size_t kNewestKept = 20;  ///< never removed by retention

  /// Reads the index and compares it with the folder: one listing, and one manifest for each unknown run.
  /// @throws IoError, PermissionError  the folder cannot be listed or the index not be written
  RunIndex(std::filesystem::path file, std::filesystem::path runs_folder);

  /// Adds a run that begins. @throws IoError, PermissionError
  void begin(const std::string& run, uid_t owner);
  /// Updates a run from its folder; removes a run whose folder no longer exists. Cost: this one folder.
  void update(const std::string& run);
  /// @throws UsageError  no such run, or no incident   @throws IoError, PermissionError
  void acknowledge(const std::string& run);
  /// Removes the folder with all its content; `latest`, if it was this run, then names the newest one that is left with
  /// an accepted model, or is removed. @returns its size [bytes]
  /// @throws UsageError  no such run, or in progress   @throws PermissionError  `by` is neither its owner nor root
  /// @throws IoError  cannot be removed
  std::uint64_t remove(const std::string& run, uid_t by);

  /// Removes the oldest removable runs until the rest is within the budget. Never removes one of the newest
  /// kNewestKept, an accepted one, an unacknowledged incident, one in progress, or one of `in_use`. A run that cannot
  /// be removed is logged and kept. Cost within the budget: independent of the number of runs.
  Retention keep_within(std::uint64_t budget_bytes, const std::set<std::string>& in_use);

  [[nodiscard]] const std::map<std::string, IndexedRun>& runs() const noexcept { return runs_; }
  [[nodiscard]] std::uint64_t bytes() const noexcept { return bytes_; }

 private:
  void load();
  void add(const std::string& run, IndexedRun facts);
  void forget(const std::string& run);
  void append(const std::string& run) const;
  void compare_with_folder();
  [[nodiscard]] IndexedRun& known(const std::string& run);
  [[nodiscard]] std::vector<std::string> removable(const std::set<std::string>& in_use) const;
  void mend_latest() const noexcept;
  void remove_until(std::uint64_t budget_bytes, const std::set<std::string>& in_use, Retention& retention);
  [[nodiscard]] std::string refusal(std::uint64_t budget_bytes) const;

  std::filesystem::path file_;
  std::filesystem::path folder_;
  std::map<std::string, IndexedRun> runs_;
  std::uint64_t bytes_ = 0;
  std::int64_t last_sequence_ = 0;
};

}  // namespace eha::service
