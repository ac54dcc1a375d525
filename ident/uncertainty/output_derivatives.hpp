// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "ident/model/model_output.hpp"
#include "ident/uncertainty/bode_curve.hpp"

namespace eha::ident {

/// Returns the model with its terms by rising order, the order of parameter keys.
[[nodiscard]] Model with_rising_terms(Model model);

/// Derivatives of a model's output at the rows of a comparison by the parameters of a covariance, by differences of
/// simulations: count by p, 0 by past input. A step is a hundredth of the standard error, at most 0.01 for an order and
/// 1 % of any other value.
/// @param model  as with_rising_terms() gives it
/// Cost: a simulation a parameter.
[[nodiscard]] Eigen::MatrixXd output_derivatives(const Model& model, OutputOnRecord& outputs,
                                                 const ParameterCovariance& known);

}  // namespace eha::ident
