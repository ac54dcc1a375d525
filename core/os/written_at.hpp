// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace eha::os {

/// "2026-01-31 14:05", when the newest of the files was written, UTC; empty where this is not known.
[[nodiscard]] std::string written_at(const std::vector<std::filesystem::path>& files);

}  // namespace eha::os
