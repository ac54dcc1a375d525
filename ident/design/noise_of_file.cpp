// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/design/noise_of_file.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "ident/excitation/tone.hpp"

namespace eha::ident {

std::optional<StoredNoise> stored_noise(const Model& model) {
  if (!model.validation || !model.bode || model.bode->frequency_Hz.empty()) return {};
  std::vector<double> correlation;  // at lags 0, 1, ...
  const Correlation& acf = model.validation->acf;
  for (std::size_t i = 0; i < acf.lags.size(); ++i) {
    if (acf.lags[i] == static_cast<int>(correlation.size())) correlation.push_back(acf.values[i]);
  }
  const auto samples = static_cast<double>(model.validation->score.samples);
  // Of the part whose residual the stored standard errors are of.
  const double power = model.estimation ? model.estimation->score.mse : model.validation->score.mse;
  if (correlation.empty() || !(samples > 0.0) || !(power > 0.0)) return {};
  StoredNoise noise;
  noise.compared_step_s = 0.5 / model.bode->frequency_Hz.back();
  noise.power = power;
  noise.model.variance = power;
  std::vector<double> c;
  double share = 1.0;  // of the power, that the model leaves
  double least = 0.0;
  const auto highest = std::min<std::size_t>(correlation.size() - 1, kHighestAutoregression);
  for (std::size_t order = 1; order <= highest && share > 0.0; ++order) {
    double reflection = correlation[order];
    for (std::size_t j = 0; j < c.size(); ++j) reflection -= c[j] * correlation[order - 1 - j];
    reflection /= share;
    if (!(std::abs(reflection) < 1.0)) break;
    std::vector<double> next = c;
    for (std::size_t j = 0; j < c.size(); ++j) next[j] -= reflection * c[c.size() - 1 - j];
    next.push_back(reflection);
    c = std::move(next);
    share *= 1.0 - reflection * reflection;
    const double bic = samples * std::log(share) + static_cast<double>(order) * std::log(samples);
    if (!(bic < least)) continue;
    least = bic;
    noise.model.coefficients = Eigen::Map<const Eigen::VectorXd>(c.data(), static_cast<Eigen::Index>(c.size()));
    noise.model.variance = power * share;
  }
  noise.correlation.assign(correlation.begin(), correlation.begin() + 1 + noise.model.coefficients.size());
  return noise;
}

ResidualModel coloured_residual(const StoredNoise& noise, Eigen::Index rows) {
  ResidualModel model;
  const Eigen::VectorXd& c = noise.model.coefficients;
  model.coefficients.assign(c.begin(), c.end());
  double sum = -noise.power;
  for (std::size_t k = 0; k < static_cast<std::size_t>(rows); ++k) {
    double value = 0.0;
    if (k < noise.correlation.size()) {
      value = noise.power * noise.correlation[k];
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

ResidualModel white_residual(const StoredNoise& noise, Eigen::Index rows) {
  ResidualModel model;
  model.autocovariance.assign(1, noise.model.variance);
  model.effective_samples = static_cast<double>(rows);
  return model;
}

double noise_power(const StoredNoise& noise, double frequency_Hz) {
  std::complex<double> filter = 1.0;
  for (Eigen::Index j = 0; j < noise.model.coefficients.size(); ++j) {
    const double turn = -kTwoPi * frequency_Hz * noise.compared_step_s * static_cast<double>(j + 1);
    filter -= noise.model.coefficients[j] * std::polar(1.0, turn);
  }
  return noise.model.variance / std::norm(filter);
}

}  // namespace eha::ident
