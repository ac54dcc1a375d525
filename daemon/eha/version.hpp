// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace eha::cli {

/// Returns "eha 0.1.0", then a line for each library with its version, and whether the comedi backend is built in.
[[nodiscard]] std::string version_text();

}  // namespace eha::cli
