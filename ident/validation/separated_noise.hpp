// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ident/signal/autoregression.hpp"

namespace eha::ident {

/// A residual without what the parameters' errors make of it.
struct SeparatedNoise {
  Eigen::VectorXd clean;    ///< the residual less the mean of their effect, given the residual
  Eigen::MatrixXd unknown;  ///< a root of the covariance that their effect still has
  Autoregression model;     ///< of the noise
  /// With further orders: what BIC leaves out of a noise that is no autoregression, as behind a filter, is small at
  /// each lag and yet alarms a test of all lags (5 % of records at 1 %; 1 % with these).
  Autoregression tested;
};

/// For e = error z + noise, z standard normal and the noise autoregressive, by expectation maximisation.
/// @param e      more than kHighestAutoregression rows
/// @param error  as many rows, p columns
/// @param start  of the noise's model; null: white, as a noise that could make the errors' effect itself would leave it
///               where it is
/// Cost O(n p^2). Dempster, Laird and Rubin, J. R. Stat. Soc. B 39 (1977).
[[nodiscard]] SeparatedNoise separated_noise(const Eigen::VectorXd& e, const Eigen::MatrixXd& error,
                                             const Autoregression* start = nullptr);

/// Makes white noise that a filter has passed white again: each row less its prediction from those before it, over the
/// prediction's standard deviation. Durbin's recursion. @param correlation  of that noise, at lags 0, 1, ...; empty: no
/// filter, the columns as they are
[[nodiscard]] Eigen::MatrixXd without_filter(const Eigen::MatrixXd& columns, const std::vector<double>& correlation);

}  // namespace eha::ident
