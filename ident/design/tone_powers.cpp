// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/design/tone_powers.hpp"

#include "ident/linear_algebra/least_squares_solvers.hpp"

namespace eha::ident {
namespace {

constexpr int kMostRounds = 500;
constexpr double kGapToOptimum = 1.05;   // greatest over mean worth of a tone
constexpr double kMultiplierRate = 0.3;  // power of a limit's use, one round
constexpr double kRidge = 1e-9;          // of the information's diagonal; an optimum may lack directions
constexpr double kLeastPower = 1e-12;    // of the greatest, so that a tone may come back

}  // namespace

Eigen::VectorXd tone_powers(const ToneProblem& problem) {
  const Eigen::Index tones = problem.response.rows();
  const Eigen::Index parameters = problem.response.cols();
  Eigen::VectorXd power = Eigen::VectorXd::Ones(tones);
  Eigen::VectorXd multiplier = Eigen::VectorXd::Ones(problem.cost.rows());
  power /= (problem.cost * power).maxCoeff();
  for (int round = 0; round < kMostRounds; ++round) {
    const Eigen::VectorXd weight = power.cwiseQuotient(problem.noise);
    Eigen::MatrixXd information = (problem.response.adjoint() * weight.asDiagonal() * problem.response).real();
    const Eigen::VectorXd scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    information = scale.asDiagonal() * information * scale.asDiagonal();
    information.diagonal().array() += kRidge;
    const Eigen::VectorXd row =
        scale.cwiseProduct(solve_symmetric(information, Eigen::VectorXd::Unit(parameters, problem.target)));
    // Worth of unit power: the decrease of the target's variance.
    const Eigen::VectorXd worth = (problem.response * row).cwiseAbs2().cwiseQuotient(problem.noise);
    const Eigen::VectorXd use = problem.cost * power;
    multiplier = multiplier.array() * use.array().pow(kMultiplierRate);
    multiplier /= multiplier.dot(use);
    const Eigen::VectorXd price = problem.cost.transpose() * multiplier;
    const double mean = worth.dot(power);
    const Eigen::VectorXd gap = worth.cwiseQuotient(price) / mean;
    if (round > 0 && gap.maxCoeff() < kGapToOptimum) break;
    power = power.cwiseProduct(gap.cwiseSqrt());
    power = power.cwiseMax(kLeastPower * power.maxCoeff());
    power /= (problem.cost * power).maxCoeff();
  }
  return power;
}

}  // namespace eha::ident
