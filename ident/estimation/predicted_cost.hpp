// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/output_error/output_error.hpp"

namespace eha::ident {

/// Compared rows that a prediction from linearised outputs needs.
constexpr Eigen::Index kFewestRowsToPredict = 10 * kHighestAutoregression;

/// The cost, a sum of squares, after one undamped Gauss-Newton step by those columns.
/// @param columns  derivatives of the output, one a coordinate; may be none
/// @param residual measured less simulated, of as many rows
/// @param step     receives the step of each column
/// Cost: a pivoted QR decomposition.
[[nodiscard]] double predicted_cost(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual,
                                    Eigen::VectorXd& step);

/// The same for all coordinates of a model at theta; infinite where the model grows. @param work  counted on
/// Cost: a simulation with derivatives.
[[nodiscard]] double cost_after_a_step(const OutputError& problem, const Eigen::VectorXd& theta, Work& work);

}  // namespace eha::ident
