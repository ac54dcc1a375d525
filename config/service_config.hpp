// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace eha::config {

/// A whole ehad.toml.
struct ServiceConfig {
  double disk_budget_GiB = 20.0;       ///< of all runs together; beyond it the oldest removable runs are removed
  double worker_cpu_time_s = 1800.0;   ///< of one identification, all its threads together
  double worker_wall_time_s = 3600.0;  ///< of one identification
  double worker_memory_MiB = 4096.0;   ///< address space of one identification
};

/// Reads ehad's own configuration; returns the defaults if the file does not exist.
/// @throws ConfigError      unreadable, not TOML, or wrong: every error at once, in file order
/// @throws PermissionError  the caller may not read it
[[nodiscard]] ServiceConfig load_service_config(const std::string& path);

/// Reads the configuration from text in memory; file_name is used in messages only.
[[nodiscard]] ServiceConfig parse_service_config(std::string_view text, const std::string& file_name);

}  // namespace eha::config
