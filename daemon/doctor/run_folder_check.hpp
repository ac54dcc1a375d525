// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "daemon/doctor/check.hpp"

namespace eha::doctor {

/// The folder for runs.
struct RunsFolder {
  std::filesystem::path folder;       ///< as requested
  std::filesystem::path existing;     ///< the folder, or the nearest existing one above it
  int write_error = 0;                ///< errno of the access check on `existing`; 0 when it may be written
  int space_error = 0;                ///< errno of reading the free space; 0 when known
  std::uint64_t available_bytes = 0;  ///< free for this user
};

/// Reads permissions and free space; creates nothing.
[[nodiscard]] RunsFolder look_at_runs_folder(const std::filesystem::path& folder);

/// Checks whether runs can be written, and for how long.
[[nodiscard]] std::vector<Check> check_runs_folder(const RunsFolder& runs, double sample_period_s);

}  // namespace eha::doctor
