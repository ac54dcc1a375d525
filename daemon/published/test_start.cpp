// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/published/test_start.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/model/model_output.hpp"

namespace eha::published {
namespace {

constexpr double kDifference = 1e-4;  // of the output, for the effect of a state
constexpr int kRounds = 6;            // of Gauss and Newton

/// Responses over a whole record to a unit of each value of the start; one column for the offset where the orders are
/// not whole.
Eigen::MatrixXd effects_of(const ident::Model& model, const ident::Record& record) {
  const ident::Comparison every_row{
      .first = 0, .every = 1, .count = static_cast<std::size_t>(record.input.size()), .taps = {}};
  if (!model.grey_box) {
    if (!ident::has_whole_orders(model.transfer_function.denominator))
      return Eigen::MatrixXd::Ones(record.input.size(), 1);
    return ident::OutputOnRecord(record, every_row).of(model).free;
  }
  const Eigen::VectorXd here = ident::simulate(model, record.input, record.step_s);
  const double step = kDifference * std::sqrt((record.output.array() - record.output.mean()).square().mean());
  Eigen::MatrixXd effects(record.input.size(), static_cast<Eigen::Index>(model.initial_state.size()));
  for (Eigen::Index i = 0; i < effects.cols(); ++i) {
    ident::Model moved = model;
    moved.initial_state[static_cast<std::size_t>(i)] += step;
    effects.col(i) = (ident::simulate(moved, record.input, record.step_s) - here) / step;
  }
  return effects;
}

void move(ident::Model& model, const Eigen::VectorXd& by) {
  if (model.initial_state.empty()) {
    model.initial_output += by[0];
    return;
  }
  for (Eigen::Index i = 0; i < by.size(); ++i) model.initial_state[static_cast<std::size_t>(i)] += by[i];
}

std::size_t states_of(const ident::Model& model) {
  if (model.grey_box) return model.grey_box->kind->states;
  if (!ident::has_whole_orders(model.transfer_function.denominator)) return 0;
  return static_cast<std::size_t>(std::lround(ident::highest_order(model.transfer_function.denominator)));
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
  model.initial_state.resize(states_of(model), 0.0);
  const Eigen::VectorXd estimated = ident::simulate(of_estimation, estimating.input.head(n), estimating.step_s);
  const double output_variance = (estimating.output.array() - estimating.output.mean()).square().mean();
  const double prior = std::sqrt(std::max(output_variance, std::numeric_limits<double>::min()));
  const double error = std::sqrt(std::max(model.estimation->score.mse, std::numeric_limits<double>::min()));
  Eigen::VectorXd moved;  // scaled
  // A linear model is moved to its place at once.
  for (int round = 0; round < (model.grey_box ? kRounds : 1); ++round) {
    const Eigen::MatrixXd effects = effects_of(model, record);
    if (effects.cols() == 0 || !effects.allFinite()) return model;  // a model that grows
    const Eigen::VectorXd scale =
        (effects.colwise().norm() / std::sqrt(static_cast<double>(effects.rows()))).cwiseMax(1e-300).cwiseInverse();
    if (round == 0) moved = Eigen::VectorXd::Zero(effects.cols());
    Eigen::MatrixXd system(n + effects.cols(), effects.cols());
    Eigen::VectorXd right(system.rows());
    system.topRows(n) = effects.topRows(n) * scale.asDiagonal() / error;
    system.bottomRows(effects.cols()).setIdentity();
    system.bottomRows(effects.cols()) /= prior;
    const Eigen::VectorXd simulated = ident::simulate(model, record.input.head(n), record.step_s);
    right.head(n) = ((record.output.head(n) - simulated) - (estimating.output.head(n) - estimated)) / error;
    right.tail(effects.cols()) = -moved / prior;
    const Eigen::VectorXd by = ident::solve_full_rank(system, right);
    move(model, scale.cwiseProduct(by));
    moved += by;
  }
  return model;
}

}  // namespace eha::published
