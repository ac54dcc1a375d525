// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ident/model/model.hpp"
#include "ident/uncertainty/autoregression.hpp"
#include "ident/uncertainty/covariance.hpp"

namespace eha::ident {

/// What a model file tells of the noise in its compared samples.
struct StoredNoise {
  double power = 0.0;               ///< mean square [output unit^2]
  Autoregression model;             ///< variance [output unit^2]
  std::vector<double> correlation;  ///< at lags 0 .. order of the model
  double compared_step_s = 0.0;     ///< time between compared samples
};

/// The autoregressive model of a stored residual, by Levinson's recursion from its autocorrelation and mean square; the
/// order is the one of least BIC up to 10.
/// @returns nothing for a model without validation or Bode curve, whose last point gives the spacing
[[nodiscard]] std::optional<StoredNoise> stored_noise(const Model& model);

/// The residual of a record of so many compared rows: coloured as it is, or what whitening leaves of it.
[[nodiscard]] ResidualModel coloured_residual(const StoredNoise& noise, Eigen::Index rows);
[[nodiscard]] ResidualModel white_residual(const StoredNoise& noise, Eigen::Index rows);

/// Power of the noise at a frequency: |sum of its innovations' response|^2 variance, for a white noise its variance.
[[nodiscard]] double noise_power(const StoredNoise& noise, double frequency_Hz);

}  // namespace eha::ident
