// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace eha::service {

/// A run that was removed.
struct RemovedRun {
  std::string name;
  std::uint64_t bytes = 0;
};

/// Result of keep_within_budget.
struct Retention {
  std::vector<RemovedRun> removed;
  std::uint64_t bytes = 0;   ///< of the runs that are left
  bool over_budget = false;  ///< and none of them may go
};

/// Removes the oldest runs without an accepted model until all together are within the budget. Runs with an accepted
/// model, runs in progress and those in `kept` stay. Blocks on the disk; a run that cannot be looked at or removed is
/// reported in the log and left.
Retention keep_within_budget(const std::filesystem::path& runs_folder, std::uint64_t budget_bytes,
                             const std::set<std::string>& kept);

}  // namespace eha::service
