// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

namespace eha::record {

/// SHA-256 of a file's content, 64 lower-case hexadecimal digits (FIPS 180-4, through libcrypto). Cost: one read.
/// @throws PermissionError, IoError
[[nodiscard]] std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace eha::record
