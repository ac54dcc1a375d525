// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace eha::delays {

/// Returns the first line of a kernel file, without blanks at its end; empty if it cannot be read.
[[nodiscard]] std::string first_line(const std::filesystem::path& file);

/// Reads the kernel's list of CPUs: "0-2,5" is 0, 1, 2, 5. Skips parts that are no number or range.
[[nodiscard]] std::vector<int> cpu_list(std::string_view text);

}  // namespace eha::delays
