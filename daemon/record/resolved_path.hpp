// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

namespace eha::record {

/// Returns the path with links followed and no slash at its end. Refuses a name that holds the end of a line or another
/// control character: `latest` may lead to it, and what stands behind the end could imitate a message of the program.
/// @throws IoError, PermissionError, DataError
[[nodiscard]] std::filesystem::path resolved_path(const std::filesystem::path& path);

}  // namespace eha::record
