// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "daemon/ehad/queue.hpp"

namespace eha::service {

/// Completes the runs that were on when the program died, each for itself: one that cannot be recovered is reported and
/// left, the others are not kept waiting by it. Blocks on the disk.
/// @param before_each  called before each run that is recovered, which may take its time
void recover_runs(const std::filesystem::path& runs_folder, const std::function<void()>& before_each);

/// Gives account of the experiments that were on when the program died: none is played again, none is forgotten. After
/// recover_runs.
void settle(std::vector<Entry>& entries, const std::filesystem::path& runs_folder);

/// What the manifest says of the models: [{"name", "accepted", ...}]; empty when there is nothing to read.
[[nodiscard]] Json models_of(const std::filesystem::path& run_folder) noexcept;

}  // namespace eha::service
