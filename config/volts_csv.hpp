// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "core/volts_file.hpp"

namespace eha::config {

/// Reads the voltages of a CSV file: a header row with a column voltage_V, other columns are ignored, as are lines
/// that begin with #. If there is a column time_s, its rows must be evenly spaced.
/// @param path  of the file   @param name  kept in the result
/// @throws ConfigError  cannot be read, no such column, a value that is not a finite number, an uneven row; with the
/// line
[[nodiscard]] VoltsFile read_volts_csv(const std::filesystem::path& path, const std::string& name);

}  // namespace eha::config
