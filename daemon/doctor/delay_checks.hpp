// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "daemon/delays/delays.hpp"
#include "daemon/doctor/check.hpp"

namespace eha::doctor {

/// A warning for each thing that can make ticks late, or one line that says there is none.
/// @param cpu  to which the loop is bound
[[nodiscard]] std::vector<Check> check_delays(const std::vector<delays::Delay>& standing, std::optional<int> cpu);

}  // namespace eha::doctor
