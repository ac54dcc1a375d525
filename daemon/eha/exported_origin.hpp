// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/controller_config.hpp"
#include "core/display_unit.hpp"

// What the comments of exported code and the pages of comparisons say of where they are from, so that a file on a PLC
// tells what it was made of.

namespace eha::cli {

/// "File axis.toml of 2026-01-31 14:05 UTC, SHA-256 4f..". As untrusted as the file's name.
/// @throws IoError, PermissionError  the file cannot be read
[[nodiscard]] std::string file_line(const std::filesystem::path& file);

/// A run, record or model file that a page is of: "runs/a: begun 2026-01-31T14:05:00Z UTC on simulated rig", or the
/// file as file_line(), with its path.   @throws as file_line()
[[nodiscard]] std::string source_line(const std::string& source);

/// Lines for the comments of an exported controller: its file, rig, model, and what it promises. Each is safe in a
/// comment (core/code_text.hpp).
/// @throws as file_line()
[[nodiscard]] std::vector<std::string> origin_lines(const std::filesystem::path& file,
                                                    const config::ControllerConfig& controller,
                                                    const DisplayUnit& unit);

}  // namespace eha::cli
