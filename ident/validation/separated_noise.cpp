// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/separated_noise.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "ident/linear_algebra/least_squares_solvers.hpp"

namespace eha::ident {
namespace {

constexpr int kRounds = 4;  // of the estimation of the noise
constexpr Eigen::Index kFurtherOrders = 3;

}  // namespace

SeparatedNoise separated_noise(const Eigen::VectorXd& e, const Eigen::MatrixXd& error, const Autoregression* start) {
  SeparatedNoise noise{e, Eigen::MatrixXd(e.size(), 0), {}, {}};
  const Eigen::Index p = error.cols();
  if (start != nullptr) {
    noise.model = *start;
  } else if (p > 0) {
    const Eigen::Index rows = e.size() - kHighestAutoregression;
    const Eigen::VectorXd rest = e - error * solve_pivoted(error, e);
    noise.model.samples = static_cast<std::size_t>(rows);
    noise.model.variance = rest.tail(rows).squaredNorm() / static_cast<double>(rows);
  } else {
    noise.model = autoregression(e);
  }
  for (int round = 0; p > 0 && round < kRounds; ++round) {
    const Eigen::MatrixXd seen = whitened(error, noise.model);
    const double variance = noise.model.variance;
    if (!(variance > 0.0)) break;
    const Eigen::MatrixXd information = Eigen::MatrixXd::Identity(p, p) + seen.transpose() * seen / variance;
    const Eigen::LLT<Eigen::MatrixXd> root(information);
    noise.clean = e - error * root.solve(seen.transpose() * whitened(e, noise.model) / variance);
    noise.unknown = root.matrixL().solve(error.transpose()).transpose();
    noise.model = autoregression(noise.clean, noise.unknown);
  }
  noise.tested = autoregression(noise.clean, noise.unknown, kFurtherOrders);
  return noise;
}

Eigen::MatrixXd without_filter(const Eigen::MatrixXd& columns, const std::vector<double>& correlation) {
  if (correlation.size() < 2) return columns;
  Eigen::MatrixXd white(columns.rows(), columns.cols());
  std::vector<double> c;
  double variance = correlation[0];
  for (Eigen::Index k = 0; k < columns.rows(); ++k) {
    white.row(k) = columns.row(k);
    for (std::size_t j = 0; j < c.size(); ++j) white.row(k) -= c[j] * columns.row(k - 1 - static_cast<Eigen::Index>(j));
    white.row(k) *= std::sqrt(correlation[0] / variance);
    if (c.size() + 1 >= correlation.size()) continue;
    double reflection = correlation[c.size() + 1];
    for (std::size_t j = 0; j < c.size(); ++j) reflection -= c[j] * correlation[c.size() - j];
    reflection /= variance;
    const std::vector<double> before = c;
    for (std::size_t j = 0; j < c.size(); ++j) c[j] -= reflection * before[before.size() - 1 - j];
    c.push_back(reflection);
    variance *= 1.0 - reflection * reflection;
  }
  return white;
}

}  // namespace eha::ident
