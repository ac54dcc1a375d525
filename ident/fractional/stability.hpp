// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "ident/fractional/transfer_function.hpp"

namespace eha::ident {

struct StabilityReport {
  bool stable = false;
  std::string test;         ///< "matignon" or "argument_principle"
  double margin_rad = 0.0;  ///< least |arg pole| - pi/2 on the principal sheet; at most pi/2
  /// Order of the pole at 0 that the structure declares, 1 for an integrator. `stable` and `margin_rad` then describe
  /// the other poles.
  double integrator_order = 0.0;
};

/// Counts the zeros of the denominator with |arg s| < half_angle_rad on the principal sheet, except a factor s^n. Uses
/// the argument principle along the ray arg s = half_angle_rad. Orders are never rounded.
/// @param half_angle_rad  (0, pi)
/// Cost: some hundred evaluations of the denominator.
[[nodiscard]] int zeros_in_sector(const std::vector<Term>& denominator, double half_angle_rad);

/// Whether some mode of G grows: a pole with positive real part. An integrator (a pole at 0) does not grow. A G with an
/// order beyond +-kOrderLimit counts as growing: the cost of the tests rises with the orders.
[[nodiscard]] bool grows(const TransferFunction& g);

/// Bounded-input bounded-output stability with its margin. Orders that are multiples of one base order q with degree at
/// most 24 are decided by Matignon's theorem (every root of the polynomial in s^q outside |arg| <= q pi/2), others by
/// the argument principle. A pole at the origin is not stable; its margin is 0.
/// Matignon, CESA'96 (1996); argument principle: Ahlfors, Complex Analysis, ch. 4.
[[nodiscard]] StabilityReport stability(const TransferFunction& g);

/// The same for a structure that declares a pole at 0: `stable` and `margin_rad` describe the other poles,
/// integrator_order the declared one. Equals stability() if G has no pole at 0.
[[nodiscard]] StabilityReport stability_beside_integrator(const TransferFunction& g);

}  // namespace eha::ident
