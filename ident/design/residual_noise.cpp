// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/design/residual_noise.hpp"

#include <cmath>
#include <complex>
#include <cstddef>

#include "ident/excitation/tone.hpp"

namespace eha::ident {

ResidualModel coloured_residual(const ResidualNoise& noise, Eigen::Index rows) {
  ResidualModel model;
  model.coefficients = noise.coefficients;
  double sum = -noise.power;
  for (std::size_t k = 0; k < static_cast<std::size_t>(rows); ++k) {
    double value = 0.0;
    if (k < noise.autocorrelation.size()) {
      value = noise.power * noise.autocorrelation[k];
    } else {
      for (std::size_t j = 0; j < model.coefficients.size(); ++j) {
        value += model.coefficients[j] * model.autocovariance[k - 1 - j];
      }
    }
    model.autocovariance.push_back(value);
    sum += 2.0 * value;
  }
  const auto samples = static_cast<double>(rows);
  model.effective_samples = sum > noise.power ? samples * noise.power / sum : samples;
  return model;
}

ResidualModel white_residual(const ResidualNoise& noise, Eigen::Index rows) {
  ResidualModel model;
  model.autocovariance.assign(1, noise.variance);
  model.effective_samples = static_cast<double>(rows);
  return model;
}

Autoregression whitening_model(const ResidualNoise& noise) {
  const auto order = static_cast<Eigen::Index>(noise.coefficients.size());
  return {Eigen::Map<const Eigen::VectorXd>(noise.coefficients.data(), order), noise.variance, 0};
}

double noise_power(const ResidualNoise& noise, double step_s, double frequency_Hz) {
  std::complex<double> filter = 1.0;
  for (std::size_t j = 0; j < noise.coefficients.size(); ++j) {
    filter -= noise.coefficients[j] * std::polar(1.0, -kTwoPi * frequency_Hz * step_s * static_cast<double>(j + 1));
  }
  return noise.variance / std::norm(filter);
}

}  // namespace eha::ident
