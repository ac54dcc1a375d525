// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/residual_tests.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <vector>

#include "ident/linear_algebra/spectra.hpp"
#include "ident/signal/autoregression.hpp"
#include "ident/uncertainty/covariance.hpp"
#include "ident/uncertainty/output_derivatives.hpp"

namespace eha::ident {
namespace {

constexpr Eigen::Index kLags = 20;
constexpr double kDriftOverNoise = 3.0;
constexpr double kDriftOverError = 2.0;
constexpr double kLagRank = 1e-6;  // lags of a slow input run together

Eigen::MatrixXd centred(const Eigen::MatrixXd& columns) { return columns.rowwise() - columns.colwise().mean(); }

double lagged_product(const Eigen::VectorXd& a, Eigen::Index lag) {
  return a.tail(a.size() - lag).dot(a.head(a.size() - lag));
}

ResidualTest judged(double statistic, Eigen::Index degrees) {
  ResidualTest test{statistic, static_cast<std::size_t>(degrees), 1.0};
  if (degrees > 0 && std::isfinite(statistic)) {
    test.p = boost::math::cdf(
        boost::math::complement(boost::math::chi_squared(static_cast<double>(degrees)), std::max(0.0, statistic)));
  }
  return test;
}

/// @param freedom  rows that the noise's variance was estimated from, less what was estimated beside it
ResidualTest input_test(const Eigen::VectorXd& w, const Eigen::MatrixXd& input, const Eigen::MatrixXd& error,
                        double variance, double freedom) {
  if (input.colwise().norm().maxCoeff() <= 0.0 || !(variance > 0.0)) return {};
  const ThinSvd svd = thin_svd(input);
  const Eigen::Index rank = (svd.values.array() > kLagRank * svd.values[0]).count();
  const Eigen::MatrixXd q = svd.left.leftCols(rank);
  const Eigen::MatrixXd seen = q.transpose() * error;
  Eigen::MatrixXd covariance = seen * seen.transpose();
  covariance.diagonal().array() += variance;
  const Eigen::VectorXd z = q.transpose() * w;
  ResidualTest test = judged(z.dot(covariance.llt().solve(z)), rank);
  if (rank > 0 && std::isfinite(test.statistic) && freedom > 1.0) {
    const auto degrees = static_cast<double>(rank);
    test.p = boost::math::cdf(
        boost::math::complement(boost::math::fisher_f(degrees, freedom), std::max(0.0, test.statistic) / degrees));
  }
  return test;
}

ResidualTest whiteness_test(const Eigen::VectorXd& w, const Eigen::MatrixXd& error, Eigen::Index order) {
  const auto n = static_cast<double>(w.size());
  const auto added = [&](Eigen::Index lag) {
    double sum = 0.0;
    for (const auto& column : error.colwise()) sum += lagged_product(column, lag);
    return sum;
  };
  const double power = w.squaredNorm() - added(0);
  if (!(power > 0.0)) return {};
  double sum = 0.0;
  for (Eigen::Index lag = 1; lag <= kLags; ++lag) {
    const double r = (lagged_product(w, lag) - added(lag)) / power;
    sum += r * r / (n - static_cast<double>(lag));
  }
  return judged(n * (n + 2.0) * sum, kLags - order);
}

ResidualDrift drift_of(const Eigen::VectorXd& e, const Eigen::MatrixXd& error) {
  const Eigen::VectorXd line = Eigen::VectorXd::LinSpaced(e.size(), -0.5, 0.5);
  const Eigen::VectorXd weights = line / line.squaredNorm();
  const double slope = weights.dot(e);
  const double left = std::sqrt((e - slope * line).squaredNorm() / static_cast<double>(e.size()));
  return {std::abs(slope), kDriftOverNoise * left + kDriftOverError * (error.transpose() * weights).norm()};
}

}  // namespace

std::optional<ResidualTests> residual_tests(const TestedPart& part) {
  const Eigen::Index rows = part.residual.size() - kHighestAutoregression;
  if (rows < 3 * kLags) return {};
  const Eigen::VectorXd e = centred(part.residual);
  if (!(e.squaredNorm() > 0.0) || !e.allFinite()) return {};
  const Autoregression noise = autoregression(e);
  const Eigen::VectorXd w = centred(whitened(e, noise));
  const Eigen::MatrixXd input = centred(whitened(centred(part.past_input), noise));
  const Eigen::MatrixXd error = centred(whitened(centred(part.parameter_error), noise));
  ResidualTests tests;
  tests.ar_order = static_cast<std::size_t>(noise.coefficients.size());
  const auto n = static_cast<double>(noise.samples);
  const double freedom = n - static_cast<double>(noise.coefficients.size()) - 1.0;
  tests.input = input_test(w, input, error, noise.variance * n / std::max(1.0, freedom), freedom);
  tests.whiteness = whiteness_test(w, error, noise.coefficients.size());
  tests.drift = drift_of(e, part.parameter_error);
  return tests;
}

TestedPart tested_part(const Model& model, OutputOnRecord& outputs, std::size_t first, const Eigen::VectorXd& residual,
                       const ParameterCovariance& known) {
  TestedPart part;
  const Comparison& comparison = outputs.comparison();
  const auto begin = std::max(static_cast<Eigen::Index>(first), kLags);
  const Eigen::Index rows = static_cast<Eigen::Index>(comparison.count) - begin;
  if (rows < 1 || residual.size() < rows) return part;
  part.residual = residual.tail(rows);
  const Eigen::VectorXd input = picked(outputs.record().input, comparison);
  part.past_input.resize(rows, kLags + 1);
  for (Eigen::Index lag = 0; lag <= kLags; ++lag) part.past_input.col(lag) = input.segment(begin - lag, rows);

  const Eigen::MatrixXd derivatives = output_derivatives(with_rising_terms(model), outputs, known).bottomRows(rows);
  // A model written by hand, or fitted by the paper's procedure, has no covariance.
  part.parameter_error =
      derivatives.cols() > 0 ? Eigen::MatrixXd(derivatives * covariance_root(known.matrix)) : derivatives;
  if (!part.parameter_error.allFinite()) part.parameter_error.resize(rows, 0);
  return part;
}

}  // namespace eha::ident
