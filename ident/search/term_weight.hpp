// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

namespace eha::ident {

inline constexpr double kSlightWeight = 1e-2;  ///< of a term, against one: below this its coordinate is linear

/// Weight of a denominator term at the reference frequency: proportional to the coordinate where the term hardly
/// matters, so that the term can vanish and reappear; exponential above.
inline double weight(double x) { return x < 1.0 ? kSlightWeight * x : kSlightWeight * std::exp(x - 1.0); }
/// Its derivative by the coordinate.
inline double weight_slope(double x) { return x < 1.0 ? kSlightWeight : weight(x); }
/// The coordinate of a weight.
inline double weight_coordinate(double value) {
  const double x = value / kSlightWeight;
  return x < 1.0 ? x : 1.0 + std::log(x);
}

}  // namespace eha::ident
