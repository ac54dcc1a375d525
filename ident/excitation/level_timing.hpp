// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "core/option_issue.hpp"

namespace eha::ident {

/// Issues of the key hold_s of an excitation that jumps: from one tick to less than the duration.
[[nodiscard]] std::vector<OptionIssue> check_hold(double hold_s, double step_s, double duration_s);

}  // namespace eha::ident
