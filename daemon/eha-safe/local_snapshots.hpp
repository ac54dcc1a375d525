// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <vector>

namespace eha {

/// Where a process that opens a card itself makes the folder of its snapshot: the user's runtime folder, else that of
/// temporary files.
[[nodiscard]] std::filesystem::path local_snapshot_base();

/// The beginning of that folder's name, six characters of mkdtemp behind it; and the snapshot's name in it.
inline constexpr const char* kLocalSnapshotFolder = "eha-";
inline constexpr const char* kLocalSnapshot = "safe.json";

/// Snapshots of such processes of this user that stand there now: each belongs to a run that is on, or to one that was
/// killed together with its guard. Another user's are not named: they may hold anything.
[[nodiscard]] std::vector<std::filesystem::path> find_local_snapshots();

}  // namespace eha
