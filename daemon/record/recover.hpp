// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "daemon/acquisition/run.hpp"

namespace eha::record {

/// What recover_run found.
struct Recovery {
  bool changed = false;  ///< false: the run had ended by itself and its files are complete
  acquisition::Outcome outcome = acquisition::Outcome::recovered;
  std::size_t rows = 0;          ///< intact rows in the journal
  std::uint64_t torn_bytes = 0;  ///< bytes behind the last intact block, not used
};

/// Completes a run whose process died: keeps the journal's intact blocks, writes raw.h5 and the decimated data from
/// them and the manifest with outcome `recovered` (or the journal's own, when its end was written). Never alters the
/// journal; may be repeated.
/// @throws DataError  the journal's header is damaged
/// @throws IoError    no journal, a run still in progress in another process, or a file cannot be written
Recovery recover_run(const std::filesystem::path& folder);

/// Whether a run folder wants recover_run. @throws IoError, PermissionError
[[nodiscard]] bool is_torn_run(const std::filesystem::path& folder);

/// The runs under `runs_folder` that want recover_run: their manifest says that they are still in progress, and no
/// process holds their journal. @throws IoError, PermissionError
[[nodiscard]] std::vector<std::filesystem::path> find_torn_runs(const std::filesystem::path& runs_folder);

}  // namespace eha::record
