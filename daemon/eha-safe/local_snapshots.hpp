// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <vector>

namespace eha {

/// Where `eha run --local` creates its snapshot's folder: the user's runtime folder, else the one for temporary files.
[[nodiscard]] std::filesystem::path local_snapshot_base();

/// Prefix of that folder's name, followed by six characters from mkdtemp; and the snapshot's name in it.
inline constexpr const char* kLocalSnapshotFolder = "eha-";
inline constexpr const char* kLocalSnapshot = "safe.json";

/// Snapshots that this user's local runs left there: each belongs to a run that is on, or to one that was killed
/// together with its guard. Other users' snapshots are left out because they are not trusted.
[[nodiscard]] std::vector<std::filesystem::path> find_local_snapshots();

}  // namespace eha
