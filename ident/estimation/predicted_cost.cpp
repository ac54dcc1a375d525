// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/predicted_cost.hpp"

#include <algorithm>
#include <limits>

#include "ident/linear_algebra/least_squares_solvers.hpp"

namespace eha::ident {
namespace {

constexpr double kIndependent = 1e-9;  // pivots below this share of the largest add nothing
constexpr double kLeastPredicted = 1e-300;

}  // namespace

double predicted_cost(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual, Eigen::VectorXd& step) {
  step.resize(0);
  if (columns.cols() == 0) return std::max(residual.squaredNorm(), kLeastPredicted);
  const Eigen::VectorXd scale = columns.colwise().norm().cwiseMax(kLeastPredicted).cwiseInverse();
  Eigen::MatrixXd orthonormal;
  step = scale.cwiseProduct(solve_ranked(columns * scale.asDiagonal(), residual, kIndependent, &orthonormal));
  return std::max(residual.squaredNorm() - (orthonormal.transpose() * residual).squaredNorm(), kLeastPredicted);
}

double cost_after_a_step(const OutputError& problem, const Eigen::VectorXd& theta, Work& work) {
  auto point = problem.evaluate(theta);
  work += problem.evaluation_work();
  work += problem.jacobian_work();
  if (!point || !problem.complete(theta, *point)) return std::numeric_limits<double>::infinity();
  Eigen::VectorXd step;
  return predicted_cost(point->jacobian, point->residual, step);
}

}  // namespace eha::ident
