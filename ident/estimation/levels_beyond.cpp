// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/levels_beyond.hpp"

#include "ident/fractional/simulate.hpp"
#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/model/model_output.hpp"
#include "ident/signal/kept_values.hpp"

namespace eha::ident {

using Eigen::Index;

LevelsBeyond levels_beyond(const Record& record, const Eigen::VectorXd& input, const ClippedInput& clipped,
                           const Model& model) {
  const Index rows = record.output.size();
  const auto holds = static_cast<Index>(clipped.runs.size());
  Eigen::MatrixXd columns(rows, holds + 2);
  const Eigen::VectorXd of_step = simulate(model.transfer_function, Eigen::VectorXd::Ones(rows), record.step_s);
  columns.col(holds) = of_step;
  columns.col(holds + 1).setOnes();
  for (Index k = 0; k < holds; ++k) {
    const auto& [first, last] = clipped.runs[static_cast<std::size_t>(k)];
    columns.col(k).setZero();
    columns.col(k).tail(rows - first) = of_step.head(rows - first);
    if (last + 1 < rows) columns.col(k).tail(rows - last - 1) -= of_step.head(rows - last - 1);
  }
  const Eigen::VectorXd beyond = solve_pivoted(columns, record.output - simulate(model, input, record.step_s));
  LevelsBeyond found{input};
  for (Index k = 0; k < holds; ++k) {
    const auto& [first, last] = clipped.runs[static_cast<std::size_t>(k)];
    const bool is_greatest = clipped.greatest && is_same_value(record.input[first], *clipped.greatest);
    found.input.segment(first, last - first + 1).array() += beyond[k];
    const double over = found.input[first] - record.input[first];
    if (is_greatest ? over > 0.0 : over < 0.0) found.share_beyond += 1.0 / static_cast<double>(holds);
  }
  return found;
}

}  // namespace eha::ident
