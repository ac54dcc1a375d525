// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <complex>
#include <span>
#include <vector>

#include "ident/model/model.hpp"

namespace eha::ident {

/// Covariance of the estimated parameters.
struct ParameterCovariance {
  std::vector<ParameterKey> parameters;
  Eigen::MatrixXd
      matrix;  ///< one row and column a parameter; directions that the record does not determine are left out
};

/// Logarithmic grid over the frequencies that a record resolves: from half a period of the record to the Nyquist
/// frequency of its compared samples, 40 points.
[[nodiscard]] std::vector<double> bode_frequencies(double duration_s, double compared_step_s);

/// G at a frequency, and d ln G/dp by each parameter; 0 for a parameter that does not affect G.
struct GainSlope {
  std::complex<double> gain;
  Eigen::VectorXcd slope;
};
[[nodiscard]] GainSlope gain_slope(const Model& model, const std::vector<ParameterKey>& parameters,
                                   double frequency_Hz);

/// Gain and phase of a model with their standard errors, to first order in the parameters' errors:
///   ln G = ln|G| + i arg G,  d ln G/dp = N'/N - D'/D - s delay'.
/// The phase has no jumps of a turn from one frequency to the next.
/// @param frequencies_Hz  rising, positive
/// @param known           none: the standard errors are left empty
[[nodiscard]] BodeCurve bode_curve(const Model& model, std::span<const double> frequencies_Hz,
                                   const ParameterCovariance& known);

}  // namespace eha::ident
