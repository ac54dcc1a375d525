// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace eha::ident {

/// Highest order of the residual's model. As many rows at the residual's start serve only as its past.
inline constexpr Eigen::Index kHighestAutoregression = 10;

/// Autoregressive model of a residual, e_k = sum_j c_j e_{k-j} + w_k.
struct Autoregression {
  Eigen::VectorXd coefficients;  ///< c_1, c_2, ...; empty for white
  double variance = 0.0;         ///< mean w^2 over the rows from kHighestAutoregression on
  std::size_t samples = 0;       ///< number of these rows
};

/// Estimates by least squares. Of the orders 0..10 picks the one of least n ln(variance) + order ln(n); all orders use
/// the same rows. Tries fewer orders if there are not three rows for each.
/// @param residual  more than kHighestAutoregression rows
/// @param taken     as many rows: J R with R R' the covariance of the fitted parameters, which is the noise that the
///                  fit has absorbed. The correlations of these columns are added to those of the residual.
/// @param further   orders added to the picked one, up to the highest
/// Cost O(n). Schwarz, Ann. Stat. 6 (1978).
[[nodiscard]] Autoregression autoregression(const Eigen::VectorXd& residual, const Eigen::MatrixXd& taken = {},
                                            Eigen::Index further = 0);

/// Whitens columns: returns the rows from kHighestAutoregression on, less their prediction from each column's past. For
/// the residual this is w.
[[nodiscard]] Eigen::MatrixXd whitened(const Eigen::MatrixXd& columns, const Autoregression& model);

/// Autoregressive model from an autocovariance.
struct LevinsonModel {
  std::vector<double> coefficients;  ///< c_1, c_2, ...; empty for white
  double variance = 0.0;             ///< innovation variance, in the unit of the autocovariance
};

/// Solves the Yule-Walker equations by Levinson's recursion; of the orders 0 .. highest picks the one of least BIC.
/// @param autocovariance  at lags 0 .. highest or more, the first above 0
/// @param samples         number of samples that it was computed from
/// Cost O(highest^2). Schwarz, Ann. Stat. 6 (1978).
[[nodiscard]] LevinsonModel levinson(const std::vector<double>& autocovariance, double samples, std::size_t highest);

}  // namespace eha::ident
