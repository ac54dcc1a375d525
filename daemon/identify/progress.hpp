// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>

namespace eha::identify {

/// Called in the thread that requested long work, before each step of it.
/// @param share  done so far, 0..1
/// @param step   "fitting io"; one that ends with a line feed is a result, which stays on a terminal
using Progress = std::function<void(double share, const std::string& step)>;

}  // namespace eha::identify
