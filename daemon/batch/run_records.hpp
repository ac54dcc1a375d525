// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>

#include "daemon/batch/batch_folder.hpp"

namespace eha::batch {

struct RunOptions {
  std::filesystem::path program;  ///< eha
  std::size_t jobs = 1;           ///< processes at a time, at least 1
  Shard shard = {};
  /// Called several times a second with the share of this process's completed records, and the work in progress.
  std::function<void(double, const std::string&)> progress;
  std::function<bool()> stopped;  ///< returns whether to end early
};

/// Fits every record of the shard that has no result, each by `eha fit` in a process of its own. A record that cannot
/// be read or fitted is a result, too. When stopped early, it kills the processes in progress. Their records stay open,
/// as does a record whose process was terminated from outside.
/// @returns whether all records of the shard have a result
/// @throws ConfigError  the rules themselves are wrong, so that no record can be fitted
/// @throws IoError  the batch's disk fails, also for a process, whose record stays open
/// @throws PermissionError, UsageError  as BatchFolder
bool run_records(BatchFolder& folder, const RunOptions& options);

}  // namespace eha::batch
