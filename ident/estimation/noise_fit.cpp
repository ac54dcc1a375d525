// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/noise_fit.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/output_error/output_error.hpp"
#include "ident/signal/autoregression.hpp"
#include "ident/uncertainty/covariance.hpp"

namespace eha::ident {
namespace {

constexpr int kRounds = 2;
constexpr double kGreatestLoss = 1.5;   // of a standard error
constexpr double kGreatestShift = 3.0;  // standard errors of the plain fit
constexpr double kManySamples = 1e9;
constexpr Eigen::Index kFewestSamples = 10 * kHighestAutoregression;

/// Of AR-BIC, the part that a refit with the same parameters changes.
double noise_information(const Eigen::VectorXd& residual) {
  const Autoregression noise = autoregression(residual);
  const auto n = static_cast<double>(noise.samples);
  return n * std::log(std::max(noise.variance, 1e-300)) + static_cast<double>(noise.coefficients.size()) * std::log(n);
}

/// What the estimation took from the noise: the output's change by each independent error of the parameters.
/// @param seen  the derivatives as they were fitted, whitened or not; @param residual  the same
Eigen::MatrixXd taken(const Eigen::MatrixXd& derivatives, const Eigen::MatrixXd& seen,
                      const Eigen::VectorXd& residual) {
  const std::vector<std::string> names(static_cast<std::size_t>(derivatives.cols()));
  ResidualModel noise = residual_model(residual);
  // What was taken is wanted as it is, not enlarged for the few samples that show it.
  noise.effective_samples = kManySamples;
  return derivatives * covariance_root(uncertainty(seen, names, noise).covariance);
}

/// Standard errors as a report would state them. @param seen, residual  as fitted, whitened or not
Eigen::VectorXd stated_errors(const Eigen::MatrixXd& seen, const Eigen::VectorXd& residual) {
  const std::vector<std::string> names(static_cast<std::size_t>(seen.cols()));
  return uncertainty(seen, names, residual_model(residual)).covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
}

/// Whether a parameter moved further than noise moves it. Both fits estimate the parameters of a structure that is
/// right; of one that misses a part of the plant, a weighting by what it misses makes others.
bool is_moved(const Eigen::MatrixXd& derivatives, const Eigen::VectorXd& change, const Eigen::VectorXd& errors) {
  const Eigen::VectorXd shift = solve_pivoted(derivatives, change);
  return (shift.array().abs() > kGreatestShift * errors.array()).any();
}

}  // namespace

std::optional<LocalOptimum> with_noise_model(const ComparedRecord& compared, const LocalOptimum& plain,
                                             double most_cost, Work& work) {
  if (compared.measured().size() < kFewestSamples) return {};
  const OutputError problem(compared, plain.parametrisation, plain.variant.linear);
  std::vector<ParameterKey> parameters;
  Eigen::VectorXd residual = plain.best.point.residual;
  Eigen::MatrixXd derivatives = problem.derivatives(plain.best.theta, plain.best.point.linear, parameters);
  Eigen::MatrixXd lost = taken(derivatives, derivatives, residual);
  // As large as the errors are stated: few effective samples leave them uncertain.
  const double effective = residual_model(residual).effective_samples;
  const double freedom = std::max(1.0, effective - static_cast<double>(derivatives.cols()));
  const double explained = lost.squaredNorm() * effective / freedom;
  const double before = noise_information(residual);
  const Eigen::VectorXd errors_before = stated_errors(derivatives, residual);
  const Eigen::MatrixXd plain_derivatives = derivatives;
  LocalOptimum found = plain;
  for (int round = 0; round < kRounds; ++round) {
    found.noise = autoregression(residual, lost);
    if (found.noise->coefficients.size() == 0) return {};
    const OutputError coloured(compared, plain.parametrisation, plain.variant.linear, found.noise);
    found.best = minimise(coloured, found.best.theta);
    work += found.best.work;
    const Termination end = found.best.termination;
    if (end != Termination::converged && end != Termination::at_bound) return {};
    residual = problem.residual(found.best.theta, found.best.point.linear);
    if (round + 1 == kRounds) break;
    derivatives = problem.derivatives(found.best.theta, found.best.point.linear, parameters);
    lost = taken(derivatives, whitened(derivatives, *found.noise), found.best.point.residual);
  }
  derivatives = problem.derivatives(found.best.theta, found.best.point.linear, parameters);
  const Eigen::VectorXd errors = stated_errors(whitened(derivatives, *found.noise), found.best.point.residual);
  if ((errors.array() > kGreatestLoss * errors_before.array()).any()) return {};
  if (is_moved(plain_derivatives, plain.best.point.residual - residual, errors_before)) return {};
  const double cost = residual.squaredNorm();
  const bool is_noise = cost - plain.best.point.cost <= explained && cost <= most_cost;
  if (!is_noise || !(noise_information(residual) < before)) return {};
  return found;
}

}  // namespace eha::ident
