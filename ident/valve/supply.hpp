// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

// What both gains of a valve say of its supply: each follows the square root of what drops over the valve.

namespace eha::ident {

/// What comes first where both gains have changed alike.
inline constexpr const char* kSupplyFirst =
    "look at the supply pressure first, as both gains follow the square root of what drops over the valve, and hold a "
    "ruler to the rod at two places far apart, as another scale of the sensor looks the same";

/// Returns the factor by which both gains changed alike, by a fifth or more; none otherwise.
/// @param positive, negative  each gain over the same gain before
[[nodiscard]] inline std::optional<double> common_gain_factor(double positive, double negative) noexcept {
  constexpr double kChanged = 1.2;
  constexpr double kAlike = 1.1;
  if (!(positive > 0.0) || !(negative > 0.0)) return std::nullopt;
  const double factor = std::sqrt(positive * negative);
  const bool is_alike = std::max(positive, negative) <= kAlike * std::min(positive, negative);
  return is_alike && std::max(factor, 1.0 / factor) >= kChanged ? std::optional(factor) : std::nullopt;
}

}  // namespace eha::ident
