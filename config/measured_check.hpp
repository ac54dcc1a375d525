// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "config/rig_config.hpp"

namespace eha::config {

/// Returns a sum over the measured numbers of [following]: gains, null, dead band and their uncertainties, to six
/// digits. Another digit in one of them gives another sum. Limit and pressure delay are no part of it: an owner sets
/// them.
[[nodiscard]] std::uint32_t measured_check_of(const Following& following);

/// Returns a sum over what a valve was measured with: card, channels of sensor and valve, and the sensor's scale and
/// offset.
[[nodiscard]] std::uint32_t measured_rig_check_of(const hal::Backend& backend);

/// Whether the numbers of [following] are those that one characterisation of this rig wrote. False without both sums.
[[nodiscard]] bool is_as_measured(const RigConfig& rig);

}  // namespace eha::config
