// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/rig_config.hpp"
#include "config/valve_estimate.hpp"
#include "ident/model/model.hpp"

namespace eha::tune {

/// Null and dead band of a valve as measured, or as a model's map has them.
struct FoundMap {
  config::DeadZone zone = {};
  config::DeadZone half_width = {};  ///< of the 95 % intervals of a model; of a measured valve 0 [V]
  double map_error_V = 0.0;          ///< of a model's map, as ident::map_error()
};

/// Those of a model with a map. An interval that is a least one, as of a short record, is taken twice.
[[nodiscard]] FoundMap found_map(const ident::Model& model);

/// What null and dead band of [following] and a found valve have in common.
enum class FollowingAgreement {
  one_valve,         ///< they differ by no more than those of one valve do
  within_interval,   ///< nor with the model's intervals: its record knows the valve less well than [following]
  within_map_error,  ///< the error of the model's map alone makes the difference
  other_valve,
};

/// Returns how far the error of a model's map may have moved null and dead band beyond what those of one valve may
/// differ by anyway [V]. @param map_error_V  as ident::map_error()
[[nodiscard]] double shift_beyond_V(double map_error_V) noexcept;

[[nodiscard]] FollowingAgreement agreement_of(const config::Following& following, const FoundMap& found) noexcept;

/// Whether a model's map is of a measured valve, given its intervals and the error of the map.
[[nodiscard]] bool is_of_one_valve(const config::DeadZone& measured, const FoundMap& found) noexcept;

}  // namespace eha::tune
