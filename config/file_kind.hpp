// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace eha::config {

/// Kind of a configuration file.
enum class FileKind { rig, experiment, controller };

/// Finds the kind of a file from its top-level keys.
/// @throws ConfigError  not TOML, or none of them, or the keys of two in equal number
[[nodiscard]] FileKind kind_of(std::string_view text, const std::string& file_name);

/// Whether an experiment file measures the valve: has [characterise]. @throws ConfigError  not TOML
[[nodiscard]] bool characterises(std::string_view text, const std::string& file_name);

/// Whether an experiment file moves the rod back from beyond a travel limit: has way_back = true.
/// @throws ConfigError  not TOML
[[nodiscard]] bool brings_back(std::string_view text, const std::string& file_name);

/// A configuration file's content.
/// @throws ConfigError      missing, a directory, empty, binary, too large, or unreadable
/// @throws PermissionError  the caller may not read it
[[nodiscard]] std::string read_config_file(const std::string& path);

}  // namespace eha::config
