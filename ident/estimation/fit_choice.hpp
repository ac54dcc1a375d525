// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "ident/coordinates/parametrisation.hpp"
#include "ident/estimation/variants.hpp"
#include "ident/search/least_squares.hpp"

namespace eha::ident {

/// "Strong" evidence, as a difference of BIC, begins here (Kass and Raftery, J. Am. Stat. Assoc. 90, 1995).
constexpr double kStrongEvidence = 6.0;

/// A local optimum of one variant on the whole record.
struct LocalOptimum {
  Variant variant;
  Parametrisation parametrisation;
  LeastSquaresResult best;
  std::size_t free = 0;                      ///< parameters estimated
  std::optional<Autoregression> noise = {};  ///< with which `best` was found, if any
};

/// n_eff ln(cost/n) + p ln(n_eff): the residual's colour leaves fewer independent samples than rows.
[[nodiscard]] double effective_bic(double cost, Eigen::Index rows, std::size_t free, double effective_samples);

/// Whether the slowest mode is so slow that the record cannot tell it from an integrator: the lowest frequency at which
/// the constant of the denominator crosses another term is far below one period a record.
[[nodiscard]] bool looks_integrating(const LocalOptimum& optimum, double duration_s);

/// The optimum to report: the best by BIC. If that one looks integrating, takes the best one that does not, provided
/// that the evidence against it is weak and its cost nearly as small: a slow drift can look like an integrator.
[[nodiscard]] const LocalOptimum& choose(const std::vector<LocalOptimum>& optima, double duration_s);

}  // namespace eha::ident
