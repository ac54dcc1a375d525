// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/autoregression.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

namespace eha::ident {
namespace {

constexpr double kTiny = 1e-300;

}  // namespace

Autoregression autoregression(const Eigen::VectorXd& residual, const Eigen::MatrixXd& taken) {
  const Eigen::Index n = residual.size() - kHighestAutoregression;
  const Eigen::Index highest = std::clamp<Eigen::Index>(n / 3, 0, kHighestAutoregression);
  const Eigen::Index series = 1 + taken.cols();
  Eigen::VectorXd target(series * n);
  Eigen::MatrixXd past(series * n, highest);
  const auto put = [&](const auto& column, Eigen::Index at) {
    target.segment(at, n) = column.tail(n);
    for (Eigen::Index lag = 1; lag <= highest; ++lag) {
      past.col(lag - 1).segment(at, n) = column.segment(kHighestAutoregression - lag, n);
    }
  };
  put(residual, 0);
  for (Eigen::Index k = 0; k < taken.cols(); ++k) put(taken.col(k), (k + 1) * n);
  // One factorisation serves every order: what the first p columns leave of the target is the tail of Q'y.
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(past);
  const Eigen::VectorXd rotated = qr.householderQ().adjoint() * target;
  const auto samples = static_cast<double>(n);
  Autoregression model;
  model.samples = static_cast<std::size_t>(n);
  Eigen::Index order = 0;
  double least = 0.0;
  for (Eigen::Index p = 0; p <= highest; ++p) {
    const double variance = rotated.tail(target.size() - p).squaredNorm() / samples;
    const double bic = samples * std::log(std::max(variance, kTiny)) + static_cast<double>(p) * std::log(samples);
    if (p > 0 && !(bic < least)) continue;
    least = bic;
    order = p;
    model.variance = variance;
  }
  model.coefficients =
      qr.matrixQR().topLeftCorner(order, order).triangularView<Eigen::Upper>().solve(rotated.head(order));
  return model;
}

Eigen::MatrixXd whitened(const Eigen::MatrixXd& columns, const Autoregression& model) {
  const Eigen::Index n = columns.rows() - kHighestAutoregression;
  Eigen::MatrixXd innovations = columns.bottomRows(n);
  for (Eigen::Index j = 0; j < model.coefficients.size(); ++j) {
    innovations -= model.coefficients[j] * columns.middleRows(kHighestAutoregression - 1 - j, n);
  }
  return innovations;
}

LevinsonModel levinson(const std::vector<double>& autocovariance, double samples, std::size_t highest) {
  LevinsonModel best{{}, autocovariance[0]};
  std::vector<double> c;
  double variance = autocovariance[0];
  double least = samples * std::log(std::max(variance, kTiny));
  for (std::size_t order = 1; order <= highest && variance > 0.0; ++order) {
    double reflection = autocovariance[order];
    for (std::size_t j = 0; j < c.size(); ++j) reflection -= c[j] * autocovariance[order - 1 - j];
    reflection /= variance;
    // Rounding, or a stored sequence that is no autocovariance.
    if (!(std::abs(reflection) < 1.0)) break;
    std::vector<double> next = c;
    for (std::size_t j = 0; j < c.size(); ++j) next[j] -= reflection * c[c.size() - 1 - j];
    next.push_back(reflection);
    c = std::move(next);
    variance *= 1.0 - reflection * reflection;
    const double bic = samples * std::log(std::max(variance, kTiny)) + static_cast<double>(order) * std::log(samples);
    if (!(bic < least)) continue;
    least = bic;
    best = {c, variance};
  }
  return best;
}

}  // namespace eha::ident
