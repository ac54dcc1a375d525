// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string_view>

#include "ident/fractional/transfer_function.hpp"

namespace eha::ident {

/// Method of simulating a fractional transfer function.
enum class SimulationMethod {
  exact,  ///< exact for a held input: aliased sum; stable models only
  gl1,    ///< Grunwald-Letnikov, first order, as in the paper
  cq2,    ///< BDF2 convolution quadrature
};

/// "exact", "gl1" or "cq2". Throws UsageError, naming the three, for anything else.
[[nodiscard]] SimulationMethod simulation_method(std::string_view name);

/// Zero-history response of G to an input held between samples (zero-order hold).
/// @param input   N samples, finite, spaced step_s
/// @param step_s  [s], positive
/// @returns N samples; row k is the output just before input[k] takes effect
/// @throws ConfigError  G is not proper or not well formed, or `exact` or `cq2` was asked of an unstable G
/// @throws DataError    a sample of input is not finite
/// Cost O(N log N) for exact and cq2, and for gl1 above a crossover; O(N^2) for gl1 of unstable models.
[[nodiscard]] Eigen::VectorXd simulate(const TransferFunction& g, const Eigen::Ref<const Eigen::VectorXd>& input,
                                       double step_s, SimulationMethod method = SimulationMethod::exact);

}  // namespace eha::ident
