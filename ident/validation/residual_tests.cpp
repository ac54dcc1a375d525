// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/residual_tests.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <vector>

#include "ident/linear_algebra/spectra.hpp"
#include "ident/model/model_output.hpp"
#include "ident/structure/structure.hpp"
#include "ident/uncertainty/autoregression.hpp"

namespace eha::ident {
namespace {

constexpr Eigen::Index kLags = 20;
constexpr double kRankThreshold = 1e-6;  // lags of a slow input run together
constexpr double kShareOfError = 1e-2;   // of the standard error, a step of the differences
constexpr double kLongestStep = 1e-2;    // of an order, or of any other value

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

ResidualTest input_test(const Eigen::VectorXd& w, const Eigen::MatrixXd& input, const Eigen::MatrixXd& error,
                        double variance) {
  if (input.colwise().norm().maxCoeff() <= 0.0 || !(variance > 0.0)) return {};
  const ThinSvd svd = thin_svd(input);
  const Eigen::Index rank = (svd.values.array() > kRankThreshold * svd.values[0]).count();
  const Eigen::MatrixXd q = svd.left.leftCols(rank);
  const Eigen::MatrixXd seen = q.transpose() * error;
  Eigen::MatrixXd covariance = seen * seen.transpose();
  covariance.diagonal().array() += variance;
  const Eigen::VectorXd z = q.transpose() * w;
  return judged(z.dot(covariance.llt().solve(z)), rank);
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

/// Where a model whose terms stand by rising order keeps a parameter's value; null where no single value is it.
double* place_of(Model& model, const ParameterKey& key) {
  TransferFunction& g = model.transfer_function;
  switch (key.role) {
    case ParameterRole::numerator_coefficient:
      return &g.numerator.at(key.index).coefficient;
    case ParameterRole::denominator_coefficient:
      return &g.denominator.at(key.index).coefficient;
    case ParameterRole::numerator_order:
      return &g.numerator.at(key.index).order;
    case ParameterRole::denominator_order:
      return &g.denominator.at(key.index).order;
    case ParameterRole::delay:
      return &g.delay_s;
    case ParameterRole::input_bias:
      return &model.input_bias;
    case ParameterRole::valve_null:
      return model.input_map ? &model.input_map->null : nullptr;
    case ParameterRole::dead_band:
      return model.input_map ? &model.input_map->dead_band : nullptr;
    case ParameterRole::negative_gain_ratio:
      return model.input_map ? &model.input_map->negative_gain_ratio : nullptr;
    case ParameterRole::initial_state:
      return key.index < model.initial_state.size() ? &model.initial_state[key.index] : nullptr;
    default:
      // The mean is taken off, so an offset has no effect; past input is far from the part tested.
      return nullptr;
  }
}

void move(Model& model, const ParameterKey& key, double by) {
  if (double* place = place_of(model, key)) *place += by;
  if (key.role != ParameterRole::base_order) return;
  TransferFunction& g = model.transfer_function;
  const double q = g.denominator.at(normalised_index(g.denominator.size())).order;
  for (Term& term : g.numerator) term.order *= 1.0 + by / q;
  for (Term& term : g.denominator) term.order *= 1.0 + by / q;
}

double value_scale(Model& model, const ParameterKey& key) {
  const double* place = place_of(model, key);
  return place == nullptr || is_order(key.role) ? 1.0 : std::abs(*place);
}

/// Root of a covariance that may lack directions: R R' = C.
Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd inverse = scale.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
  const Eigen::MatrixXd correlation = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  // Of a symmetric, nonnegative matrix the singular vectors are its eigenvectors.
  const ThinSvd svd = thin_svd(correlation);
  return scale.asDiagonal() * svd.left * svd.values.cwiseSqrt().asDiagonal();
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
  tests.input = input_test(w, input, error, noise.variance);
  tests.whiteness = whiteness_test(w, error, noise.coefficients.size());
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

  Model rising = model;
  const auto by_order = [](const Term& a, const Term& b) { return a.order < b.order; };
  std::stable_sort(rising.transfer_function.numerator.begin(), rising.transfer_function.numerator.end(), by_order);
  std::stable_sort(rising.transfer_function.denominator.begin(), rising.transfer_function.denominator.end(), by_order);
  const Eigen::VectorXd here = outputs.of(rising).total(rising).tail(rows);
  Eigen::MatrixXd derivatives = Eigen::MatrixXd::Zero(rows, known.matrix.cols());
  for (Eigen::Index i = 0; i < derivatives.cols(); ++i) {
    const ParameterKey& key = known.parameters[static_cast<std::size_t>(i)];
    const double error = std::sqrt(std::max(0.0, known.matrix(i, i)));
    const double step = std::min(kShareOfError * error, kLongestStep * value_scale(rising, key));
    if (!(step > 0.0) || (place_of(rising, key) == nullptr && key.role != ParameterRole::base_order)) continue;
    Model moved = rising;
    move(moved, key, step);
    derivatives.col(i) = (outputs.of(moved).total(moved).tail(rows) - here) / step;
  }
  // A model written by hand, or fitted by the paper's procedure, has no covariance.
  part.parameter_error = derivatives.cols() > 0 ? Eigen::MatrixXd(derivatives * root_of(known.matrix)) : derivatives;
  if (!part.parameter_error.allFinite()) part.parameter_error.resize(rows, 0);
  return part;
}

}  // namespace eha::ident
