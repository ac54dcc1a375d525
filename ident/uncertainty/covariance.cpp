// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/uncertainty/covariance.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "ident/linear_algebra/spectra.hpp"
#include "ident/signal/autoregression.hpp"
#include "ident/signal/fft.hpp"
#include "ident/statistics/distributions.hpp"

namespace eha::ident {
namespace {

// Directions of the scaled parameter space that move the output less than this share of the strongest one are lost in
// rounding (the derivatives are good to about 1e-9).
constexpr double kWeakDirection = 1e-8;
constexpr double kMostLags = 60.0;
// The effective samples are those of a mean. A residual that wanders, as that of a structure without the friction of
// the plant, has few of them, though the record says much of what moves faster.
constexpr double kLeastFreedom = 3.0;

/// Gamma J for the Toeplitz matrix of an autocovariance, by circulant embedding.
Eigen::MatrixXd toeplitz_times(const std::vector<double>& autocovariance, const Eigen::MatrixXd& columns) {
  const auto n = static_cast<std::size_t>(columns.rows());
  const RealFft fft(fast_length(2 * n));
  std::vector<double> signal(fft.length(), 0.0);
  for (std::size_t k = 0; k < n; ++k) {
    signal[k] = autocovariance[k];
    if (k > 0) signal[fft.length() - k] = autocovariance[k];
  }
  std::vector<std::complex<double>> kernel(fft.bins());
  std::vector<std::complex<double>> spectrum(fft.bins());
  fft.forward(signal, kernel);
  Eigen::MatrixXd product(columns.rows(), columns.cols());
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    std::fill(signal.begin(), signal.end(), 0.0);
    std::copy_n(columns.col(c).data(), n, signal.begin());
    fft.forward(signal, spectrum);
    for (std::size_t j = 0; j < spectrum.size(); ++j) spectrum[j] *= kernel[j].real();
    fft.inverse(spectrum, signal);
    for (std::size_t k = 0; k < n; ++k) {
      product(static_cast<Eigen::Index>(k), c) = signal[k] / static_cast<double>(fft.length());
    }
  }
  return product;
}

}  // namespace

ResidualModel residual_model(const Eigen::VectorXd& residual) {
  const Eigen::Index n = residual.size();
  const auto samples = static_cast<double>(n);
  const auto highest = static_cast<Eigen::Index>(std::min(kMostLags, samples / 10.0));
  std::vector<double> gamma;
  for (Eigen::Index k = 0; k <= highest; ++k) gamma.push_back(residual.head(n - k).dot(residual.tail(n - k)) / samples);

  ResidualModel model;
  model.coefficients = levinson(gamma, samples, static_cast<std::size_t>(highest)).coefficients;
  model.autocovariance.assign(static_cast<std::size_t>(n), 0.0);
  for (std::size_t k = 0; k < model.autocovariance.size(); ++k) {
    if (k <= model.coefficients.size()) {
      model.autocovariance[k] = gamma[k];
      continue;
    }
    for (std::size_t j = 0; j < model.coefficients.size(); ++j) {
      model.autocovariance[k] += model.coefficients[j] * model.autocovariance[k - 1 - j];
    }
  }
  double sum = gamma[0];
  for (std::size_t k = 1; k < model.autocovariance.size(); ++k) sum += 2.0 * model.autocovariance[k];
  model.effective_samples = sum > gamma[0] ? samples * gamma[0] / sum : samples;
  return model;
}

Uncertainty uncertainty(const Eigen::MatrixXd& derivatives, const std::vector<std::string>& names,
                        const ResidualModel& residual, const Eigen::MatrixXd& input_error) {
  const Eigen::Index p = derivatives.cols();
  const double freedom = std::max(kLeastFreedom, residual.effective_samples - static_cast<double>(p));
  Uncertainty result;
  result.interval_factor = student_exceeded(0.025, freedom);
  const Eigen::VectorXd scale = derivatives.colwise().norm().cwiseMax(1e-300).transpose();
  const Eigen::MatrixXd scaled = derivatives * scale.cwiseInverse().asDiagonal();
  const ThinSvd svd = thin_svd(scaled);
  const Eigen::VectorXd& s = svd.values;
  const double least = kWeakDirection * s[0];
  std::vector<bool> lost(static_cast<std::size_t>(p), false);
  for (Eigen::Index k = 0; k < p; ++k) {
    if (s[k] > least) continue;
    for (Eigen::Index i = 0; i < p; ++i)
      lost[static_cast<std::size_t>(i)] = lost[static_cast<std::size_t>(i)] || std::abs(svd.right(i, k)) > 0.1;
  }
  const Eigen::VectorXd inverse = (s.array() > least).select(s.cwiseMax(1e-300).cwiseInverse(), 0.0);
  const Eigen::MatrixXd& u = svd.left;
  Eigen::MatrixXd middle = residual.coefficients.empty()
                               ? Eigen::MatrixXd(residual.autocovariance[0] * Eigen::MatrixXd::Identity(p, p))
                               : Eigen::MatrixXd(u.transpose() * toeplitz_times(residual.autocovariance, u));
  middle *= residual.effective_samples / freedom;
  if (input_error.cols() > 0) {
    const Eigen::MatrixXd along = u.transpose() * input_error;
    middle += along * along.transpose();
  }
  const Eigen::MatrixXd half = scale.cwiseInverse().asDiagonal() * svd.right * inverse.asDiagonal();
  result.covariance = half * middle * half.transpose();
  result.unit_covariance = half * half.transpose();
  const Eigen::VectorXd deviation = result.covariance.diagonal().cwiseMax(1e-300).cwiseSqrt();
  result.correlation =
      deviation.cwiseInverse().asDiagonal() * result.covariance * deviation.cwiseInverse().asDiagonal();
  for (Eigen::Index i = 0; i < p; ++i) {
    if (lost[static_cast<std::size_t>(i)]) result.indistinguishable.push_back(names[static_cast<std::size_t>(i)]);
  }
  return result;
}

Eigen::MatrixXd covariance_root(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd inverse = scale.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
  const Eigen::MatrixXd correlation = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  // Of a symmetric, nonnegative matrix the singular vectors are its eigenvectors.
  const ThinSvd svd = thin_svd(correlation);
  return scale.asDiagonal() * svd.left * svd.values.cwiseSqrt().asDiagonal();
}

}  // namespace eha::ident
