// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ident/fractional/transfer_function.hpp"

namespace eha::ident {

/// Folded Grunwald-Letnikov kernel A_k = sum_i a_i h^-al_i w_k(al_i), w_0 = 1, w_k = w_{k-1} (1 - (al + 1)/k).
/// @returns N weights; cost O(N terms)
[[nodiscard]] Eigen::VectorXd gl_kernel(const std::vector<Term>& terms, double step_s, Eigen::Index samples);

/// y_n = (sum_k B_k u_{n-k} - sum_{k>=1} A_k y_{n-k}) / A_0, the paper's first-order scheme with zero history, for
/// stable and unstable models alike. A delay that is not a whole number of samples interpolates the input linearly.
/// Cost O(N^2), of integer orders O(N). Podlubny, Fractional Differential Equations (1999), ch. 7.
[[nodiscard]] Eigen::VectorXd simulate_gl_directly(const TransferFunction& g,
                                                   const Eigen::Ref<const Eigen::VectorXd>& input, double step_s);

/// Backward difference formula of a convolution quadrature.
enum class Quadrature {
  bdf1,  ///< delta(z) = 1 - z: the same numbers as Grunwald-Letnikov
  bdf2,  ///< delta(z) = 3/2 - 2 z + z^2/2
};

/// Convolution quadrature of the held input's increments with the step response,
///   Y(z) = (1 - z)/delta(z) G(delta(z)/h) U(z),
/// on a circle |z| < 1. Stable models only: the contour does not represent growth. Cost O(N log N).
/// Lubich, Numer. Math. 52 (1988).
[[nodiscard]] Eigen::VectorXd simulate_by_quadrature(const TransferFunction& g,
                                                     const Eigen::Ref<const Eigen::VectorXd>& input, double step_s,
                                                     Quadrature quadrature);

}  // namespace eha::ident
