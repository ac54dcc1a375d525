// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace eha::hal {

/// Snapshot file of the rig that the service has open; the default of eha-safe.
inline constexpr const char* kServiceSnapshot = "/run/ehad/safe.json";

/// Replaces `path` by the text of Rig::safe_snapshot(), atomically and durably (temporary file, fsync, rename).
/// @throws IoError, PermissionError
void write_safe_snapshot(std::string_view snapshot, const std::filesystem::path& path);

/// The file's text, for safe_action().
/// @throws IoError      cannot be read
/// @throws ConfigError  far longer than a snapshot
[[nodiscard]] std::string read_safe_snapshot(const std::filesystem::path& path);

}  // namespace eha::hal
