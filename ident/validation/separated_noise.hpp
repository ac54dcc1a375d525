// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ident/signal/autoregression.hpp"

namespace eha::ident {

/// A residual without the effect of the parameters' errors.
struct SeparatedNoise {
  Eigen::VectorXd clean;    ///< the residual less the conditional mean of the effect
  Eigen::MatrixXd unknown;  ///< a root of the effect's conditional covariance
  Autoregression model;     ///< of the noise
  /// Model with further orders. If the noise is not autoregressive (as behind a filter), the orders that BIC leaves out
  /// are small at each lag, yet alarm a test of all lags (5 % of records at 1 %; 1 % with these).
  Autoregression tested;
};

/// Separates e = error z + noise, z standard normal and the noise autoregressive, by expectation maximisation.
/// @param e      more than kHighestAutoregression rows
/// @param error  as many rows, p columns
/// @param start  of the noise's model; null: white, as a noise that could make the errors' effect itself would leave it
///               where it is
/// Cost O(n p^2). Dempster, Laird and Rubin, J. R. Stat. Soc. B 39 (1977).
[[nodiscard]] SeparatedNoise separated_noise(const Eigen::VectorXd& e, const Eigen::MatrixXd& error,
                                             const Autoregression* start = nullptr);

/// Whitens white noise that a filter has coloured: each row less its prediction from those before it, over the
/// prediction's standard deviation. Durbin's recursion.
/// @param correlation  of the filtered noise, at lags 0, 1, ...; empty: no filter, returns the columns unchanged
[[nodiscard]] Eigen::MatrixXd without_filter(const Eigen::MatrixXd& columns, const std::vector<double>& correlation);

}  // namespace eha::ident
