// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "ident/model/model.hpp"
#include "ident/signal/autoregression.hpp"
#include "ident/uncertainty/covariance.hpp"

namespace eha::ident {

/// Residual of a record with a number of compared rows: coloured like the noise, or white after whitening.
[[nodiscard]] ResidualModel coloured_residual(const ResidualNoise& noise, Eigen::Index rows);
[[nodiscard]] ResidualModel white_residual(const ResidualNoise& noise, Eigen::Index rows);

/// Returns the noise as an autoregressive model for whitening.
[[nodiscard]] Autoregression whitening_model(const ResidualNoise& noise);

/// Power of the noise at a frequency: |sum of its innovations' response|^2 variance, for a white noise its variance.
/// @param step_s  between the samples
[[nodiscard]] double noise_power(const ResidualNoise& noise, double step_s, double frequency_Hz);

}  // namespace eha::ident
