// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::ident {

// Boost's distributions, compiled once. Shares are those of the upper tail, 0..1; degrees of freedom are positive.

/// The value that a normal variable of mean 0 and variance 1 exceeds with this probability.
[[nodiscard]] double normal_exceeded(double share);

/// The same of Student's t.
[[nodiscard]] double student_exceeded(double share, double degrees);

/// The same of chi-squared.
[[nodiscard]] double chi_squared_exceeded(double share, double degrees);
/// The probability that chi-squared exceeds a value. @param noncentrality  of the distribution, 0 for the central one
[[nodiscard]] double chi_squared_share(double value, double degrees, double noncentrality = 0.0);

/// The value that Fisher's F exceeds with this probability. @param degrees  of the numerator
[[nodiscard]] double fisher_exceeded(double share, double degrees, double freedom);
/// The probability that F exceeds a value.
[[nodiscard]] double fisher_share(double value, double degrees, double freedom);

}  // namespace eha::ident
