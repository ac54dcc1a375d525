// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/output_error/output_error.hpp"

namespace eha::ident {

/// Compared rows that a prediction from linearised outputs needs.
constexpr Eigen::Index kFewestRowsToPredict = 10 * kHighestAutoregression;

/// The cost after one undamped step by those columns. @param step  of the columns
[[nodiscard]] double predicted_cost(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual,
                                    Eigen::VectorXd& step);

/// The same for all coordinates of a model at theta; infinite where the model grows. @param work  counted on
[[nodiscard]] double cost_after_a_step(const OutputError& problem, const Eigen::VectorXd& theta, Work& work);

}  // namespace eha::ident
