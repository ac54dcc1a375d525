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

/// Facts about a run, kept without reading its folder.
struct IndexedRun {
  std::int64_t sequence = 0;  ///< in the order of the runs' beginnings, from 1; the clock may be wrong, this is not
  uid_t owner = 0;            ///< who submitted it; root where that is unknown
  std::string outcome;        ///< as in the manifest; in_progress until the run is over
  bool accepted = false;      ///< a model was accepted
  bool acknowledged = false;  ///< somebody has seen its incident (eha runs ack)
  std::uint64_t bytes = 0;    ///< of its files

  /// Whether it ended otherwise than completed: faulted, interrupted, deadline, write_failed, recovered.
  [[nodiscard]] bool is_incident() const;
  /// Whether retention may remove it, regardless of its age.
  [[nodiscard]] bool may_go() const;
};

/// A run that was removed.
struct RemovedRun {
  std::string name;
  std::uint64_t bytes = 0;
};

/// Result of RunIndex::keep_within().
struct Retention {
  std::vector<RemovedRun> removed;
  std::uint64_t bytes = 0;  ///< of the runs that are left
  std::string refusal;      ///< why the next run must not begin; empty within the budget
};

/// Index of the service's run folders: the cost of a run does not grow with the number of kept runs. Kept in a file of
/// JSON lines, one appended for each change, the last line of a run valid; rewritten at the start. What the file lacks
/// is read from the folders. Blocks on the disk. Not thread-safe.
class RunIndex {
 public:
  static constexpr std::size_t kNewestKept = 20;  ///< never removed by retention

  /// Reads the index and compares it with the folder: one listing, and one manifest for each run that it does not know.
  /// @throws IoError, PermissionError  the folder cannot be listed or the index not be written
  RunIndex(std::filesystem::path file, std::filesystem::path runs_folder);

  /// A run begins. @throws IoError, PermissionError
  void begin(const std::string& run, uid_t owner);
  /// Takes over what a run's folder says now; forgets a run whose folder has gone. Cost: this one folder.
  void update(const std::string& run);
  /// @throws UsageError  no such run, or no incident   @throws IoError, PermissionError
  void acknowledge(const std::string& run);
  /// Removes the folder, whatever is in it. @returns its size [bytes]
  /// @throws UsageError  no such run, or in progress   @throws PermissionError  `by` is neither its owner nor root
  /// @throws IoError  cannot be removed
  std::uint64_t remove(const std::string& run, uid_t by);

  /// Removes the oldest runs that may go until the rest is within the budget: never one of the newest kNewestKept, an
  /// accepted one, an incident nobody acknowledged, one in progress, or one of `in_use`. A run that cannot be removed
  /// is logged and left. Cost within the budget: none that grows with the number of runs.
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
  void remove_until(std::uint64_t budget_bytes, const std::set<std::string>& in_use, Retention& retention);
  [[nodiscard]] std::string refusal(std::uint64_t budget_bytes) const;

  std::filesystem::path file_;
  std::filesystem::path folder_;
  std::map<std::string, IndexedRun> runs_;
  std::uint64_t bytes_ = 0;
  std::int64_t last_sequence_ = 0;
};

}  // namespace eha::service
