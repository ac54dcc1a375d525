// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/rig_config.hpp"
#include "config/valve_estimate.hpp"

namespace eha::tune {

/// What null and dead band of [following] and a found valve have in common.
enum class FollowingAgreement {
  one_valve,         ///< they differ by no more than those of one valve do
  within_map_error,  ///< the error of the model's map alone makes the difference
  other_valve,
};

/// Returns how far the error of a model's map may have moved null and dead band beyond what those of one valve may
/// differ by anyway [V]. @param map_error_V  as ident::map_error()
[[nodiscard]] double shift_beyond_V(double map_error_V) noexcept;

/// @param map_error_V  of the model that the valve is from; 0 for a measured valve
[[nodiscard]] FollowingAgreement agreement_of(const config::Following& following, const config::DeadZone& found,
                                              double map_error_V) noexcept;

}  // namespace eha::tune
