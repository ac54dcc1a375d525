// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "ident/validation/parameter_change.hpp"

namespace eha::report {

/// What alone explains another valve's map.
enum class MapCause : std::uint8_t { unknown, leak, leak_and_valve, friction };

/// What on a bench commonly changes the parameters that changed, those of one kind in one sentence: "K: commonly the
/// supply pressure, the load or the sensor's scale ...". A gain whose factor is that of two units: the units; gains
/// alone, by one factor: the sensor's scale beside the supply. A record shows which parameter changed and not why,
/// which the last sentence says. Empty where none changed.
/// @param changes  of one comparison, each of another run or model
/// @param found    what the records showed of the valve's map, which then stands first
[[nodiscard]] std::string causes_of(const std::vector<const ident::PlantChange*>& changes,
                                    MapCause found = MapCause::unknown);

inline constexpr std::string_view kUntilKnown = "Rely on no model of before until that is known.";

/// "Look on the bench for what changed. dead_band: commonly the valve ...", then a last sentence; empty where no
/// parameter changed.
[[nodiscard]] std::string advice_on(const std::vector<const ident::PlantChange*>& changes, MapCause found,
                                    std::string_view then);

/// Whether a parameter changed that belongs to the valve: null, dead band or the ratio of its gains.
[[nodiscard]] bool changes_valve(const ident::PlantChange& change);

}  // namespace eha::report
