// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

namespace eha::ident {

inline constexpr double kSlightWeight = 1e-2;  ///< relative to 1: below this the coordinate is linear

/// Weight of a denominator term at the reference frequency. Small weights are proportional to the coordinate, so that
/// the term can vanish and reappear; larger ones are exponential.
inline double weight(double x) { return x < 1.0 ? kSlightWeight * x : kSlightWeight * std::exp(x - 1.0); }
/// Its derivative by the coordinate.
inline double weight_slope(double x) { return x < 1.0 ? kSlightWeight : weight(x); }
/// The coordinate of a weight.
inline double weight_coordinate(double value) {
  const double x = value / kSlightWeight;
  return x < 1.0 ? x : 1.0 + std::log(x);
}

}  // namespace eha::ident
