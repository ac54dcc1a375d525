// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "daemon/delays/delays.hpp"
#include "daemon/doctor/check.hpp"

namespace eha::doctor {

/// Returns a warning for each possible cause of late ticks, or one line that reports none.
/// @param cpu  of the loop
[[nodiscard]] std::vector<Check> check_delays(const std::vector<delays::Delay>& standing, std::optional<int> cpu);

}  // namespace eha::doctor
