// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <cstddef>
#include <optional>
#include <vector>

#include "ident/fractional/transfer_function.hpp"

namespace eha::ident {

/// A fractional polynomial sum_i c_i s^al_i: terms by rising order, equal orders joined, no zero coefficients.
struct ReducedPolynomial {
  std::vector<Term> terms;     ///< the lowest order is 0
  double removed_order = 0.0;  ///< of the factor s^n that was split off
};

[[nodiscard]] ReducedPolynomial reduced(std::vector<Term> terms);

/// The coarsest order q that makes all orders whole multiples, if one of degree 24 or less exists. Cost O(terms).
[[nodiscard]] std::optional<double> base_order(const ReducedPolynomial& polynomial);

/// Returns the roots of the polynomial in w = s^q, by the eigenvalues of its companion matrix.
/// @param q  as base_order()
[[nodiscard]] std::vector<std::complex<double>> commensurate_roots(const ReducedPolynomial& polynomial, double q);

/// Poles of a transfer function, without those at s = 0.
struct Poles {
  /// The poles are roots in the plane of w = s^base_order: stable if |arg w| > base_order pi/2 (Matignon). 1 if no base
  /// order exists: the poles then lie on the principal sheet of s.
  double base_order = 1.0;
  bool is_commensurate = true;
  std::vector<std::complex<double>> values;
  double order_at_zero = 0.0;  ///< n of a factor s^n of the denominator; an integrator has 1
  bool is_complete = true;     ///< false: the argument principle counts more poles than were found
};

/// Every root in w for a base order of degree 24 or less; otherwise the zeros of the denominator with |arg s| <= pi, by
/// Newton's method in ln s from a grid of starts, counted by the argument principle.
/// Precondition: check(g). Cost: up to some thousand evaluations of the denominator.
[[nodiscard]] Poles poles(const TransferFunction& g);

/// Slowest pole that is told from one at 0: no record lasts for its time constant of four months. [rad/s]
inline constexpr double kSlowestPole_rad_s = 1e-7;

/// The same poles for people: those slower than kSlowestPole_rad_s, which are an integrator's that a search rounded,
/// count as poles at 0. Cost O(poles).
[[nodiscard]] Poles with_rounded_at_zero(Poles poles);

}  // namespace eha::ident
