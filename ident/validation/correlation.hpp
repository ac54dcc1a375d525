// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "ident/model/model.hpp"

namespace eha::ident {

/// Sample autocorrelation of a residual, mean removed, lags 0..max_lag (fewer when N is smaller).
///   r(k) = sum_t e(t) e(t-k) / sum_t e(t)^2,  bounds 1.96 / sqrt(N) and 2.576 / sqrt(N)
/// A residual that is constant has r = 0 at every lag.
/// @param weights  1 at rows that were measured, 0 at the others; empty: all were. The products then are those of pairs
///                 of measured rows, and N is N_m^2 / N, about their number.
/// @throws DataError  e is empty or not finite
/// Cost O(N max_lag). Box, Jenkins, Reinsel, Time Series Analysis, sec. 2.1.
[[nodiscard]] Correlation autocorrelation(const Eigen::Ref<const Eigen::VectorXd>& e, int max_lag,
                                          const Eigen::VectorXd& weights = {});

/// Sample cross-correlation of a residual with the input, means removed, lags -max_lag..max_lag.
///   r(k) = sum_t e(t) u(t-k) / sqrt(sum e^2 sum u^2);  k > 0: the input comes first, so a value out of bounds says
///   that the model misses a part of the plant; k < 0 shows feedback or drift and is no fault by itself.
/// The bounds hold for coloured signals: if e and u are independent, N var r(k) = sum_j r_e(j) r_u(j) (Bartlett 1955;
/// Brockwell, Davis, Time Series, theorem 11.2.2; with a given periodic u it holds conditionally on u). The sum uses
/// Parzen's weights, so that it is never negative, with the bandwidth of Andrews, Econometrica 59 (1991), eq. 6.2, 6.4.
/// For a white residual this is 1.96 / sqrt(N) and 2.576 / sqrt(N).
/// @param weights  of the residual's rows, as autocorrelation(); N is the number of those that were measured
/// @throws DataError  lengths differ, are 0, or a sample is not finite
/// Cost O(N (max_lag + bandwidth)).
[[nodiscard]] Correlation cross_correlation(const Eigen::Ref<const Eigen::VectorXd>& e,
                                            const Eigen::Ref<const Eigen::VectorXd>& u, int max_lag,
                                            const Eigen::VectorXd& weights = {});

/// N of autocorrelation().
[[nodiscard]] double correlated_samples(Eigen::Index rows, const Eigen::VectorXd& weights);

/// p value of the Ljung-Box test that no positive lag of an autocorrelation differs from 0.
///   Q = N (N + 2) sum_k r(k)^2 / (N - k), chi-squared with as many degrees of freedom as lags
/// Not reduced by the number of parameters: an output-error residual is not whitened by the fit.
/// 1 when there is no positive lag. Ljung, Box, Biometrika 65 (1978).
[[nodiscard]] double ljung_box_p(const Correlation& acf, double samples);

}  // namespace eha::ident
