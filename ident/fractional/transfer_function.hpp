// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <vector>

namespace eha::ident {

/// One term coefficient * s^order of a fractional polynomial.
struct Term {
  double coefficient = 0.0;
  double order = 0.0;  ///< real, not negative
};

/// G(s) = exp(-delay_s s) * sum_j b_j s^be_j / sum_i a_i s^al_i.
struct TransferFunction {
  std::vector<Term> numerator;
  std::vector<Term> denominator;
  double delay_s = 0.0;  ///< transport delay [s], not negative
};

/// Far above the order of any plant.
constexpr double kOrderLimit = 100.0;

/// Throws ConfigError unless G has terms, finite coefficients, orders of 0..kOrderLimit, a denominator that is not
/// zero, a delay >= 0 and a numerator whose highest order does not exceed the denominator's.
void check(const TransferFunction& g);

/// Whether each term is of whole order, to 1e-9.
[[nodiscard]] bool has_whole_orders(const std::vector<Term>& terms);

/// Highest order of a polynomial's terms whose coefficient is not 0; 0 without any.
[[nodiscard]] double highest_order(const std::vector<Term>& terms);

/// G(s) on the principal branch, s != 0. Cost O(terms).
[[nodiscard]] std::complex<double> frequency_response(const TransferFunction& g, std::complex<double> s);

}  // namespace eha::ident
