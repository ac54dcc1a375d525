// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace eha::ident {

/// Highest order of the residual's model, and the rows at its beginning that only serve as its past.
inline constexpr Eigen::Index kHighestAutoregression = 10;

/// Autoregressive model of a residual, e_k = sum_j c_j e_{k-j} + w_k.
struct Autoregression {
  Eigen::VectorXd coefficients;  ///< c_1, c_2, ...; empty for white
  double variance = 0.0;         ///< mean w^2 over the rows from kHighestAutoregression on
  std::size_t samples = 0;       ///< number of these rows
};

/// By least squares. Of the orders 0..10 takes the one of the least n ln(variance) + order ln(n); every order is judged
/// by the same rows. Fewer orders are tried where there are not three rows for each.
/// @param residual  more than kHighestAutoregression rows
/// @param taken     as many rows: what an estimation took from the noise, J R with R R' the covariance of its
///                  parameters. The correlations of these columns are added to those of the residual, which lacks them.
/// @param further   orders beyond that one, up to the highest
/// Cost O(n). Schwarz, Ann. Stat. 6 (1978).
[[nodiscard]] Autoregression autoregression(const Eigen::VectorXd& residual, const Eigen::MatrixXd& taken = {},
                                            Eigen::Index further = 0);

/// The rows from kHighestAutoregression on with each column's past taken off: of the residual, w.
[[nodiscard]] Eigen::MatrixXd whitened(const Eigen::MatrixXd& columns, const Autoregression& model);

/// Autoregressive model that an autocovariance gives.
struct LevinsonModel {
  std::vector<double> coefficients;  ///< c_1, c_2, ...; empty for white
  double variance = 0.0;             ///< of what the model leaves, in the unit of the autocovariance
};

/// Yule-Walker by Levinson's recursion; of the orders 0 .. highest takes the one of least BIC.
/// @param autocovariance  at lags 0 .. highest or more, the first above 0
/// @param samples         from which it was computed
/// Cost O(highest^2). Schwarz, Ann. Stat. 6 (1978).
[[nodiscard]] LevinsonModel levinson(const std::vector<double>& autocovariance, double samples, std::size_t highest);

}  // namespace eha::ident
