// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/published/test_start.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/model/model_output.hpp"

namespace eha::published {
namespace {

constexpr double kWhole = 1e-9;

bool has_whole_orders(const ident::TransferFunction& g) {
  return std::all_of(g.denominator.begin(), g.denominator.end(),
                     [](const ident::Term& term) { return std::abs(term.order - std::round(term.order)) < kWhole; });
}

}  // namespace

ident::Model started(ident::Model model, const ident::Record& record, std::size_t rows,
                     const ident::Record& estimating) {
  const auto n = std::min({static_cast<Eigen::Index>(rows), record.input.size(), estimating.input.size()});
  const ident::Model of_estimation = model;
  model.past_input.clear();
  if (n == 0) {
    model.initial_state.clear();
    return model;
  }
  const bool has_state = has_whole_orders(model.transfer_function);
  if (has_state) {
    model.initial_state.resize(
        static_cast<std::size_t>(std::lround(ident::highest_order(model.transfer_function.denominator))), 0.0);
  }
  const ident::Comparison every_row{
      .first = 0, .every = 1, .count = static_cast<std::size_t>(record.input.size()), .taps = {}};
  const ident::ModelOutput output = ident::OutputOnRecord(record, every_row).of(model);
  Eigen::MatrixXd effects = has_state ? output.free : Eigen::MatrixXd::Ones(record.input.size(), 1);
  if (effects.cols() == 0 || !effects.allFinite()) return model;  // a model that grows
  const Eigen::VectorXd scale =
      (effects.colwise().norm() / std::sqrt(static_cast<double>(effects.rows()))).cwiseMax(1e-300).cwiseInverse();
  effects = effects * scale.asDiagonal();

  const Eigen::VectorXd estimated = ident::simulate(of_estimation, estimating.input.head(n), estimating.step_s);
  const double output_variance = (estimating.output.array() - estimating.output.mean()).square().mean();
  const double error_variance = std::max(model.estimation->score.mse, std::numeric_limits<double>::min());
  Eigen::MatrixXd system(n + effects.cols(), effects.cols());
  Eigen::VectorXd right = Eigen::VectorXd::Zero(system.rows());
  system.topRows(n) = effects.topRows(n) / std::sqrt(error_variance);
  system.bottomRows(effects.cols()).setIdentity();
  system.bottomRows(effects.cols()) /= std::sqrt(std::max(output_variance, std::numeric_limits<double>::min()));
  right.head(n) = ((record.output.head(n) - output.total(model).head(n)) - (estimating.output.head(n) - estimated)) /
                  std::sqrt(error_variance);
  const Eigen::VectorXd moved = scale.cwiseProduct(ident::solve_full_rank(system, right));
  if (!has_state) {
    model.initial_output += moved[0];
    return model;
  }
  for (Eigen::Index i = 0; i < moved.size(); ++i) model.initial_state[static_cast<std::size_t>(i)] += moved[i];
  return model;
}

}  // namespace eha::published
