// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace eha::record {

/// SHA-256 of a file's content, 64 lower-case hexadecimal digits (FIPS 180-4, through libcrypto). Cost: one read.
/// @throws PermissionError, IoError
[[nodiscard]] std::string sha256_of_file(const std::filesystem::path& path);

/// The same of bytes in memory. @throws IoError
[[nodiscard]] std::string sha256_of(std::span<const std::byte> bytes);

}  // namespace eha::record
