// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/least_squares.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

namespace eha::ident {
namespace {

constexpr double kFirstDamping = 1e-3;
constexpr double kLargestDamping = 1e12;
constexpr int kFeasibilityAttempts = 12;

/// The linearised problem min |e - J step|, reduced to as many rows as there are coordinates.
struct Linearised {
  Eigen::MatrixXd r;       ///< upper triangle of J = Q R
  Eigen::VectorXd target;  ///< Q' e

  explicit Linearised(const OutputError::Point& point) {
    const Eigen::Index n = point.jacobian.cols();
    Eigen::MatrixXd joined(point.jacobian.rows(), n + 1);
    joined << point.jacobian, point.residual;
    const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(joined);
    const Eigen::Index rows = std::min(n, joined.rows());
    r = joined.topLeftCorner(rows, n).triangularView<Eigen::Upper>();
    target = joined.topRightCorner(rows, 1);
  }
};

/// Damped least-squares step that keeps theta + step inside the box; held coordinates do not move.
Eigen::VectorXd bounded_step(const Linearised& problem, const Eigen::VectorXd& theta, const Eigen::VectorXd& lower,
                             const Eigen::VectorXd& upper, const Eigen::VectorXd& scale, double damping,
                             std::vector<bool> held) {
  const Eigen::Index n = theta.size();
  const Eigen::Index rows = problem.r.rows();
  Eigen::VectorXd step = Eigen::VectorXd::Zero(n);
  for (Eigen::Index round = 0; round <= n; ++round) {
    std::vector<Eigen::Index> free;
    // Coordinates already at their bound contribute a known change of the output.
    Eigen::VectorXd target = problem.target;
    for (Eigen::Index l = 0; l < n; ++l) {
      if (!held[static_cast<std::size_t>(l)]) {
        free.push_back(l);
      } else {
        target -= step[l] * problem.r.col(l);
      }
    }
    if (free.empty()) break;
    const auto m = static_cast<Eigen::Index>(free.size());
    const Eigen::VectorXd shrink = scale(free).cwiseInverse();
    Eigen::MatrixXd stacked(rows + m, m);
    stacked << problem.r(Eigen::all, free) * shrink.asDiagonal(), std::sqrt(damping) * Eigen::MatrixXd::Identity(m, m);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(rows + m);
    right.head(rows) = target;
    const Eigen::VectorXd solved = shrink.cwiseProduct(Eigen::HouseholderQR<Eigen::MatrixXd>(stacked).solve(right));
    bool crossed = false;
    for (Eigen::Index f = 0; f < m; ++f) {
      const Eigen::Index l = free[static_cast<std::size_t>(f)];
      step[l] = solved[f];
      const double wanted = theta[l] + step[l];
      if (wanted < lower[l] || wanted > upper[l]) {
        step[l] = std::clamp(wanted, lower[l], upper[l]) - theta[l];
        held[static_cast<std::size_t>(l)] = true;
        crossed = true;
      }
    }
    if (!crossed) break;
  }
  return step;
}

}  // namespace

std::string_view text(Termination termination) {
  switch (termination) {
    case Termination::converged:
      return "converged";
    case Termination::at_bound:
      return "converged with a parameter on its bound";
    case Termination::no_progress:
      return "no further progress";
    case Termination::evaluation_limit:
      return "evaluation limit";
    case Termination::infeasible:
      break;
  }
  return "no stable start";
}

LeastSquaresResult minimise(const OutputError& problem, const Eigen::VectorXd& start,
                            const LeastSquaresOptions& options) {
  const Eigen::VectorXd lower = problem.parametrisation().lower();
  const Eigen::VectorXd upper = problem.parametrisation().upper();
  const Eigen::VectorXd leap = problem.parametrisation().leap();
  LeastSquaresResult result;
  result.theta = start.cwiseMax(lower).cwiseMin(upper);
  auto first = problem.evaluate(result.theta, OutputError::Want::jacobian);
  result.evaluations = 1;
  for (int attempt = 0; !first && attempt < kFeasibilityAttempts; ++attempt) {
    result.theta = problem.parametrisation().with_lower_orders(result.theta).cwiseMax(lower).cwiseMin(upper);
    first = problem.evaluate(result.theta, OutputError::Want::jacobian);
    ++result.evaluations;
  }
  if (!first) return result;
  result.point = std::move(*first);
  const Eigen::Index n = result.theta.size();
  if (n == 0) {
    result.termination = Termination::converged;
    return result;
  }

  Linearised linearised(result.point);
  Eigen::VectorXd scale = Eigen::VectorXd::Constant(n, 1e-300);
  double damping = kFirstDamping;
  double growth = 2.0;
  const double total = problem.output_energy();
  const auto finish = [&](Termination termination) {
    const bool at_bound = ((result.theta - lower).array() <= 0.0 || (upper - result.theta).array() <= 0.0).any();
    result.termination = termination == Termination::converged && at_bound ? Termination::at_bound : termination;
    return result;
  };
  while (result.evaluations < options.max_evaluations) {
    // Marquardt's scaling may shrink slowly, so that one flat stretch does not let a coordinate leap.
    scale = (0.3 * scale)
                .cwiseMax(result.point.jacobian.colwise().norm().transpose())
                .cwiseMax(1e-12 * scale.maxCoeff() + 1e-300);
    const Eigen::VectorXd descent = result.point.jacobian.transpose() * result.point.residual;
    std::vector<bool> held(static_cast<std::size_t>(n));
    for (Eigen::Index l = 0; l < n; ++l) {
      held[static_cast<std::size_t>(l)] =
          (result.theta[l] <= lower[l] && descent[l] <= 0.0) || (result.theta[l] >= upper[l] && descent[l] >= 0.0);
    }
    Eigen::VectorXd step = bounded_step(linearised, result.theta, lower, upper, scale, damping, held);
    while (damping < kLargestDamping && (step.cwiseAbs().array() > leap.array()).any()) {
      damping *= 4.0;
      step = bounded_step(linearised, result.theta, lower, upper, scale, damping, held);
    }
    const Eigen::VectorXd change = linearised.r * step;
    const double predicted = linearised.target.squaredNorm() - (linearised.target - change).squaredNorm();
    // What the step changes in the output, against the output itself: below rounding nothing is left to gain.
    if (change.squaredNorm() <= options.step_tolerance * options.step_tolerance * total) {
      return finish(Termination::converged);
    }
    const auto trial = problem.evaluate(result.theta + step, OutputError::Want::value);
    ++result.evaluations;
    const double gain = trial ? result.point.cost - trial->cost : -1.0;
    if (gain > 0.0) {
      const double ratio = predicted > 0.0 ? gain / predicted : 1.0;
      const bool settled = gain <= options.cost_tolerance * result.point.cost && ratio > 0.25;
      result.theta += step;
      auto next = problem.evaluate(result.theta, OutputError::Want::jacobian);
      ++result.evaluations;
      if (!next) return finish(Termination::no_progress);
      result.point = std::move(*next);
      linearised = Linearised(result.point);
      if (settled) return finish(Termination::converged);
      damping *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * std::min(ratio, 1.0) - 1.0, 3.0));
      damping = std::max(damping, 1e-16);
      growth = 2.0;
    } else {
      const bool nothing_left = predicted >= 0.0 && predicted <= options.cost_tolerance * result.point.cost;
      if (nothing_left && trial) return finish(Termination::converged);
      damping *= growth;
      growth *= 2.0;
      if (damping > kLargestDamping) return finish(Termination::no_progress);
    }
  }
  return finish(Termination::evaluation_limit);
}

}  // namespace eha::ident
