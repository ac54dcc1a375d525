// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "daemon/doctor/check.hpp"

namespace eha::doctor {

/// Where runs would be written.
struct RunsFolder {
  std::filesystem::path folder;       ///< as asked for
  std::filesystem::path existing;     ///< it, or the nearest folder above it that exists
  int write_error = 0;                ///< errno of asking for leave to write in `existing`; 0 when granted
  int space_error = 0;                ///< errno of asking for the room left; 0 when known
  std::uint64_t available_bytes = 0;  ///< room for this user
};

/// Looks; creates nothing.
[[nodiscard]] RunsFolder look_at_runs_folder(const std::filesystem::path& folder);

/// Judges whether runs can be written, and how long ones.
[[nodiscard]] std::vector<Check> check_runs_folder(const RunsFolder& runs, double sample_period_s);

}  // namespace eha::doctor
