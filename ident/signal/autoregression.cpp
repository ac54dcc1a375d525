// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/autoregression.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ident/linear_algebra/least_squares_solvers.hpp"

namespace eha::ident {
namespace {

constexpr double kTiny = 1e-300;

/// Adds sum_k c[k - i] c[k - j], i, j = 0 .. highest, over the rows k from kHighestAutoregression on.
void add_lagged_products(const Eigen::Ref<const Eigen::VectorXd>& c, Eigen::MatrixXd& sums) {
  const Eigen::Index first = kHighestAutoregression;
  const Eigen::Index n = c.size() - first;
  const Eigen::Index count = sums.cols();
  Eigen::MatrixXd products(count, count);
  for (Eigen::Index j = 0; j < count; ++j) products(0, j) = products(j, 0) = c.tail(n).dot(c.segment(first - j, n));
  for (Eigen::Index i = 1; i < count; ++i) {
    for (Eigen::Index j = i; j < count; ++j) {
      products(i, j) = products(j, i) =
          products(i - 1, j - 1) + c[first - i] * c[first - j] - c[c.size() - i] * c[c.size() - j];
    }
  }
  sums += products;
}

}  // namespace

Autoregression autoregression(const Eigen::VectorXd& residual, const Eigen::MatrixXd& taken, Eigen::Index further) {
  const Eigen::Index n = residual.size() - kHighestAutoregression;
  const Eigen::Index highest = std::clamp<Eigen::Index>(n / 3, 0, kHighestAutoregression);
  // The rows of the residual, then the fewest rows that have the lagged products of the columns `taken`.
  const Eigen::Index more = taken.cols() > 0 ? highest + 1 : 0;
  Eigen::MatrixXd past_and_target(n + more, highest + 1);
  past_and_target.col(highest).head(n) = residual.tail(n);
  for (Eigen::Index lag = 1; lag <= highest; ++lag) {
    past_and_target.col(lag - 1).head(n) = residual.segment(kHighestAutoregression - lag, n);
  }
  if (more > 0) {
    Eigen::MatrixXd products = Eigen::MatrixXd::Zero(more, more);
    for (const auto& column : taken.colwise()) add_lagged_products(column, products);
    const Eigen::MatrixXd root = semidefinite_root(products);
    past_and_target.col(highest).tail(more) = root.col(0);
    past_and_target.leftCols(highest).bottomRows(more) = root.rightCols(highest);
  }
  // One factorisation serves every order: what the first p columns leave of the target is the tail of R's last column.
  factorise_qr(past_and_target);
  const Eigen::Index kept = std::min(highest + 1, n + more);
  const Eigen::VectorXd rotated = past_and_target.col(highest).head(kept);
  const auto samples = static_cast<double>(n);
  Autoregression model;
  model.samples = static_cast<std::size_t>(n);
  Eigen::Index order = 0;
  double least = 0.0;
  for (Eigen::Index p = 0; p <= highest; ++p) {
    const double variance = rotated.tail(kept - p).squaredNorm() / samples;
    const double bic = samples * std::log(std::max(variance, kTiny)) + static_cast<double>(p) * std::log(samples);
    if (p > 0 && !(bic < least)) continue;
    least = bic;
    order = p;
  }
  order = std::min(order + further, highest);
  model.variance = rotated.tail(kept - order).squaredNorm() / samples;
  model.coefficients =
      past_and_target.topLeftCorner(order, order).triangularView<Eigen::Upper>().solve(rotated.head(order));
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
    // Due to rounding, or to a stored sequence that is no autocovariance.
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
