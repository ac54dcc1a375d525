// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <vector>

namespace eha {

/// Returns the folder in which `eha run --local` creates its snapshot's folder: the user's runtime folder, else the one
/// for temporary files.
[[nodiscard]] std::filesystem::path local_snapshot_base();

/// Prefix of that folder's name, followed by six characters from mkdtemp; and the snapshot's name in it.
inline constexpr const char* kLocalSnapshotFolder = "eha-";
inline constexpr const char* kLocalSnapshot = "safe.json";

/// Returns the snapshots that this user's local runs left there: each belongs to a present run, or to one that was
/// killed together with its guard. Leaves out other users' snapshots, which are not trusted.
[[nodiscard]] std::vector<std::filesystem::path> find_local_snapshots();

}  // namespace eha
