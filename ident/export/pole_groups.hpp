// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <vector>

#include "ident/export/sections.hpp"

namespace eha::ident {

/// A real polynomial, highest power first.
using Polynomial = std::vector<double>;

/// Poles [rad/s] in groups that a partial fraction expansion can separate: poles nearer to each other than 0.3 of their
/// size stay together, conjugates too. @param poles  closed under conjugation
[[nodiscard]] std::vector<std::vector<std::complex<double>>> grouped(const std::vector<std::complex<double>>& poles);

/// The monic polynomial with these zeros, which are closed under conjugation.
[[nodiscard]] Polynomial from_zeros(const std::vector<std::complex<double>>& zeros);

/// The section N(s)/D(s) with the rate taken from the poles' size. @param denominator  monic, degree n >= 1
/// @param numerator  at most n coefficients  @param free  numerator of the free response F(s)/D(s), at most n
[[nodiscard]] Section section_of(const Polynomial& numerator, const Polynomial& denominator,
                                 const Polynomial& free_response = {});

}  // namespace eha::ident
