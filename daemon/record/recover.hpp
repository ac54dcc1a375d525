// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "daemon/acquisition/run.hpp"

namespace eha::record {

/// The result of recover_run().
struct Recovery {
  bool changed = false;  ///< false: the run had ended by itself and its files are complete
  acquisition::Outcome outcome = acquisition::Outcome::recovered;
  std::size_t rows = 0;          ///< intact rows in the journal
  std::size_t lost_rows = 0;     ///< rows lost to damage before the last intact block; raw.h5 marks them
  std::size_t gaps = 0;          ///< places of such damage
  std::uint64_t torn_bytes = 0;  ///< bytes after the last intact block, not used
};

/// Completes a run whose process died: writes raw.h5 and the decimated data from the journal's intact blocks, and the
/// manifest with outcome `recovered`, or with the journal's own outcome if its end was written and, for a completed
/// run, no row was lost. Never alters the journal; may be repeated.
/// @throws DataError  the journal's header is damaged and the manifest, too
/// @throws IoError    no journal, a run still in progress in another process, or a file cannot be written
Recovery recover_run(const std::filesystem::path& folder);

/// Whether recover_run() has work in a run folder. @throws IoError, PermissionError
[[nodiscard]] bool is_torn_run(const std::filesystem::path& folder);

/// The torn runs under `runs_folder`, oldest first. @throws IoError, PermissionError
[[nodiscard]] std::vector<std::filesystem::path> find_torn_runs(const std::filesystem::path& runs_folder);

/// "RUN: recovered: N rows kept, ..."
[[nodiscard]] std::string describe(const std::filesystem::path& folder, const Recovery& recovery);

/// Report of recover_torn_runs().
struct RecoveryMessages {
  std::function<void()> before_each = {};  ///< called before each recovery, which may take minutes; may be empty
  std::function<void(const std::string& message)> skipped = {};  ///< another process is writing it; may be empty
  std::function<void(const std::string& message)> recovered;
  std::function<void(const std::string& message)> failed;
};

/// Recovers every torn run under `runs_folder`. One that cannot be recovered is reported and left unchanged.
/// @throws IoError, PermissionError  the folder cannot be listed
void recover_torn_runs(const std::filesystem::path& runs_folder, const RecoveryMessages& messages);

}  // namespace eha::record
