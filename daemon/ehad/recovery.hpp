// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "daemon/ehad/queue.hpp"

namespace eha::service {

/// Completes the runs that were in progress when the program died. A run that cannot be recovered is logged and
/// skipped. Blocks on the disk.
/// @param before_each  called before each recovery, which may take minutes
void recover_runs(const std::filesystem::path& runs_folder, const std::function<void()>& before_each);

/// Closes the entries of experiments that were running when the program died. Plays none again, does not repeat a
/// finished fit, and refuses a move to a place that had not begun. Call after recover_runs.
/// @param keeps_last_rows  whether the last rows of a run survive the death of service and guard; else a run that was
///                         recovered may have slipped in them
void settle(std::vector<Entry>& entries, const std::filesystem::path& runs_folder, bool keeps_last_rows);

/// Returns the models in a run's manifest: [{"name", "accepted", ...}]; empty if there are none or it cannot be read.
[[nodiscard]] Json models_of(const std::filesystem::path& run_folder) noexcept;

}  // namespace eha::service
