// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/search/least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "ident/linear_algebra/least_squares_solvers.hpp"

namespace eha::ident {
namespace {

// Levenberg-Marquardt after Madsen, Nielsen and Tingleff, Methods for Non-Linear Least Squares Problems (2004),
// algorithm 3.16 and equation 2.21: the damping falls with the gain ratio, and grows faster with each failed step.
constexpr double kLeastDamping = 1e-16;
constexpr double kLargestDamping = 1e12;
constexpr double kFirstGrowth = 2.0;
constexpr double kGrowthFactor = 2.0;
constexpr double kLeastShrinking = 1.0 / 3.0;
constexpr double kShorterStep = 4.0;  // damping factor that shortens a step beyond what a coordinate may move
// Marquardt's scaling may shrink slowly, so that one flat stretch does not let a coordinate move far.
constexpr double kScaleMemory = 0.3;
constexpr double kLeastScale = 1e-12;  // of the largest one
constexpr double kTiny = 1e-300;       // against a division by 0
// A small fall of the cost ends the search if it exceeds this share of the predicted fall; a smaller share means that
// the prediction was bad.
constexpr double kSettledRatio = 0.25;
constexpr int kFeasibilityAttempts = 12;

/// The linearised problem min |e - J step|, reduced to as many rows as there are coordinates.
struct Linearised {
  Eigen::MatrixXd r;       ///< upper triangle of J = Q R
  Eigen::VectorXd target;  ///< Q' e

  explicit Linearised(const OutputError::Point& point) {
    const Eigen::Index n = point.jacobian.cols();
    Eigen::MatrixXd joined(point.jacobian.rows(), n + 1);
    joined << point.jacobian, point.residual;
    factorise_qr(joined);
    const Eigen::Index rows = std::min(n, joined.rows());
    r = joined.topLeftCorner(rows, n).triangularView<Eigen::Upper>();
    target = joined.topRightCorner(rows, 1);
  }
};

/// The bounds of the coordinates.
struct Box {
  Eigen::VectorXd lower;
  Eigen::VectorXd upper;

  [[nodiscard]] Eigen::VectorXd clamped(const Eigen::VectorXd& theta) const {
    return theta.cwiseMax(lower).cwiseMin(upper);
  }
  [[nodiscard]] bool is_on_bound(const Eigen::VectorXd& theta) const {
    return ((theta - lower).array() <= 0.0 || (upper - theta).array() <= 0.0).any();
  }
  /// Coordinates on a bound that the descent pushes outward.
  [[nodiscard]] std::vector<bool> pushed_outward(const Eigen::VectorXd& theta, const Eigen::VectorXd& descent) const {
    std::vector<bool> held(static_cast<std::size_t>(theta.size()));
    for (Eigen::Index l = 0; l < theta.size(); ++l) {
      held[static_cast<std::size_t>(l)] =
          (theta[l] <= lower[l] && descent[l] <= 0.0) || (theta[l] >= upper[l] && descent[l] >= 0.0);
    }
    return held;
  }
};

/// Damped least-squares step that keeps theta + step inside the box; held coordinates do not move.
Eigen::VectorXd bounded_step(const Linearised& problem, const Eigen::VectorXd& theta, const Box& box,
                             const Eigen::VectorXd& scale, double damping, std::vector<bool> held) {
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
    const Eigen::VectorXd solved = shrink.cwiseProduct(solve_full_rank(stacked, right));
    bool crossed = false;
    for (Eigen::Index f = 0; f < m; ++f) {
      const Eigen::Index l = free[static_cast<std::size_t>(f)];
      step[l] = solved[f];
      const double wanted = theta[l] + step[l];
      if (wanted < box.lower[l] || wanted > box.upper[l]) {
        step[l] = std::clamp(wanted, box.lower[l], box.upper[l]) - theta[l];
        held[static_cast<std::size_t>(l)] = true;
        crossed = true;
      }
    }
    if (!crossed) break;
  }
  return step;
}

/// The damping and the rate of its growth.
struct Damping {
  double value;
  double growth = kFirstGrowth;

  void succeed(double gain_ratio) {
    value *= std::max(kLeastShrinking, 1.0 - std::pow(2.0 * std::min(gain_ratio, 1.0) - 1.0, 3.0));
    value = std::max(value, kLeastDamping);
    growth = kFirstGrowth;
  }
  void fail() {
    value *= growth;
    growth *= kGrowthFactor;
  }
};

/// Evaluates the start, its orders lowered until the model is stable. @returns whether that succeeded
bool evaluate_start(const OutputError& problem, const Eigen::VectorXd& start, const Box& box,
                    LeastSquaresResult& result) {
  result.theta = box.clamped(start);
  const auto evaluate = [&] {
    result.work += problem.evaluation_work();
    return problem.evaluate(result.theta);
  };
  auto first = evaluate();
  for (int attempt = 0; !first && attempt < kFeasibilityAttempts; ++attempt) {
    result.theta = box.clamped(problem.parametrisation().with_lower_orders(result.theta));
    first = evaluate();
  }
  if (!first) return false;
  result.point = std::move(*first);
  return true;
}

/// Iterates from a feasible point. @returns the reason for the end
Termination iterate(const OutputError& problem, const Box& box, const LeastSquaresOptions& options,
                    LeastSquaresResult& result) {
  const Eigen::VectorXd max_step = problem.parametrisation().max_step();
  const double total = problem.output_energy();
  Linearised linearised(result.point);
  result.predicted_cost = result.point.cost - linearised.target.squaredNorm();
  Eigen::VectorXd scale = Eigen::VectorXd::Constant(result.theta.size(), kTiny);
  Damping damping{.value = result.damping > 0.0 ? result.damping : options.first_damping};
  const std::size_t most = result.work.simulations() + options.max_evaluations - 1;
  while (result.work.simulations() < most) {
    scale = (kScaleMemory * scale)
                .cwiseMax(result.point.jacobian.colwise().norm().transpose())
                .cwiseMax(kLeastScale * scale.maxCoeff() + kTiny);
    const Eigen::VectorXd descent = result.point.jacobian.transpose() * result.point.residual;
    const std::vector<bool> held = box.pushed_outward(result.theta, descent);
    Eigen::VectorXd step = bounded_step(linearised, result.theta, box, scale, damping.value, held);
    while (damping.value < kLargestDamping && (step.cwiseAbs().array() > max_step.array()).any()) {
      damping.value *= kShorterStep;
      step = bounded_step(linearised, result.theta, box, scale, damping.value, held);
    }
    const Eigen::VectorXd change = linearised.r * step;
    const double predicted = linearised.target.squaredNorm() - (linearised.target - change).squaredNorm();
    // The step's change of the output, relative to the output: below the rounding error no progress is possible.
    if (change.squaredNorm() <= options.step_tolerance * options.step_tolerance * total) return Termination::converged;
    const Eigen::VectorXd next = result.theta + step;
    auto trial = problem.evaluate(next);
    result.work += problem.evaluation_work();
    const double gain = trial ? result.point.cost - trial->cost : -1.0;
    if (gain > 0.0) {
      const double ratio = predicted > 0.0 ? gain / predicted : 1.0;
      const bool settled = gain <= options.cost_tolerance * result.point.cost && ratio > kSettledRatio;
      result.work += problem.jacobian_work();
      if (!problem.complete(next, *trial)) return Termination::no_progress;
      result.theta = next;
      result.point = std::move(*trial);
      linearised = Linearised(result.point);
      result.predicted_cost = result.point.cost - linearised.target.squaredNorm();
      if (settled) return Termination::converged;
      damping.succeed(ratio);
      result.damping = damping.value;
    } else {
      const bool nothing_left = predicted >= 0.0 && predicted <= options.cost_tolerance * result.point.cost;
      if (nothing_left && trial) return Termination::converged;
      damping.fail();
      result.damping = damping.value;
      if (damping.value > kLargestDamping) return Termination::no_progress;
    }
  }
  return Termination::evaluation_limit;
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
    case Termination::flat_ridge:
      return "converged along a flat ridge";
    case Termination::infeasible:
      break;
  }
  return "no stable start";
}

bool has_converged(Termination termination) {
  return termination == Termination::converged || termination == Termination::at_bound ||
         termination == Termination::flat_ridge;
}

bool has_less_cost(const LeastSquaresResult& a, const LeastSquaresResult& b) {
  const bool a_is_feasible = a.termination != Termination::infeasible;
  const bool b_is_feasible = b.termination != Termination::infeasible;
  return a_is_feasible && (!b_is_feasible || a.point.cost < b.point.cost);
}

LeastSquaresResult begun(const OutputError& problem, const Eigen::VectorXd& start) {
  const Box box{problem.parametrisation().lower(), problem.parametrisation().upper()};
  LeastSquaresResult result;
  if (evaluate_start(problem, start, box, result)) result.termination = Termination::evaluation_limit;
  return result;
}

void proceed(const OutputError& problem, LeastSquaresResult& result, const LeastSquaresOptions& options) {
  if (result.termination == Termination::infeasible) return;
  if (result.theta.size() == 0) {
    result.termination = Termination::converged;
    return;
  }
  if (result.point.jacobian.size() == 0) {
    ++result.work.local_searches;
    result.work += problem.jacobian_work();
    if (!problem.complete(result.theta, result.point)) {
      result.termination = Termination::infeasible;
      return;
    }
  }
  const Box box{problem.parametrisation().lower(), problem.parametrisation().upper()};
  result.termination = iterate(problem, box, options, result);
  const bool on_bound = result.termination == Termination::converged && box.is_on_bound(result.theta);
  if (on_bound) result.termination = Termination::at_bound;
}

LeastSquaresResult minimise(const OutputError& problem, const Eigen::VectorXd& start,
                            const LeastSquaresOptions& options) {
  LeastSquaresResult result = begun(problem, start);
  proceed(problem, result, options);
  return result;
}

}  // namespace eha::ident
