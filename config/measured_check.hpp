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

/// Whether an experiment or a characterisation begins with a placing a little towards mid-travel and back: nothing
/// shows that the numbers of [following] were measured on this machine, and a wrong one, or a dead sensor, is found at
/// the speed of a placing.
[[nodiscard]] bool shows_motion_first(const RigConfig& rig);

inline constexpr double kShowing_in = 0.3;     ///< greatest way of that placing
inline constexpr double kShowingLeaves = 0.5;  ///< of the way: the rod is no nearer to a travel limit than before

/// The way of that placing from a place, towards mid-travel [in].
[[nodiscard]] double showing_way_in(const RigLimits& limits, double place_in);

}  // namespace eha::config
