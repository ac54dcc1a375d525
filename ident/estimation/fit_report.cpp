// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/fit_report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ident/estimation/information.hpp"
#include "ident/estimation/model_output.hpp"
#include "ident/estimation/profile.hpp"
#include "ident/estimation/uncertainty.hpp"
#include "ident/validation/correlation.hpp"
#include "ident/validation/score.hpp"

namespace eha::ident {
namespace {

constexpr int kCorrelationLags = 20;

}  // namespace

Normalised normalised(TransferFunction g) {
  std::stable_sort(g.denominator.begin(), g.denominator.end(),
                   [](const Term& a, const Term& b) { return a.order < b.order; });
  const double divisor = g.denominator[normalised_term(g)].coefficient;
  for (Term& term : g.numerator) term.coefficient /= divisor;
  for (Term& term : g.denominator) term.coefficient /= divisor;
  return {std::move(g), divisor};
}

LinearPart as_reported(const Outcome& outcome, const TransferFunction& g, LinearSolution& solution) {
  LinearPart linear = outcome.variant.linear;
  // Reported as a parameter of its own, whether it was solved for or a coordinate.
  linear.solve_bias = linear.solve_bias || outcome.variant.bias_coordinate;
  if (linear.first_state == 0) return linear;
  linear.first_state = 0;
  linear.initial_output.fixed = false;
  const Eigen::VectorXd c = solution.initial_state;
  linear.initial_states = static_cast<int>(c.size()) - 1;
  solution.initial_output = c[0] / g.denominator[0].coefficient;
  solution.initial_state.resize(linear.initial_states);
  for (Eigen::Index i = 1; i < c.size(); ++i) {
    solution.initial_state[i - 1] =
        c[i] - solution.initial_output * g.denominator[static_cast<std::size_t>(i)].coefficient;
  }
  return linear;
}

void fill_validation(FitResult& result, const Record& record, const Comparison& comparison) {
  const ModelOutput output = output_at(result.model, record, comparison);
  result.measured = picked(record.output, comparison);
  result.simulated = output.total(result.model);
  result.time_s.resize(static_cast<Eigen::Index>(comparison.count));
  for (Eigen::Index j = 0; j < result.time_s.size(); ++j) {
    result.time_s[j] =
        record.start_s +
        record.step_s * static_cast<double>(comparison.first + static_cast<std::size_t>(j) * comparison.every);
  }
  const auto estimated = static_cast<Eigen::Index>(result.estimation_samples);
  // A model scored on another record estimates nothing here.
  if (estimated > 0) {
    result.model.estimation->score = score(result.measured.head(estimated), result.simulated.head(estimated));
  }
  const Eigen::Index rest = result.measured.size() - estimated;
  if (rest < 2) return;
  ValidationReport report;
  const Eigen::VectorXd measured = result.measured.tail(rest);
  const Eigen::VectorXd simulated = result.simulated.tail(rest);
  report.score = score(measured, simulated);
  ModelOutput tail{output.forced.tail(rest), Eigen::MatrixXd(output.free.rows() == 0 ? 0 : rest, output.free.cols())};
  if (output.free.cols() > 0) tail.free = output.free.bottomRows(rest);
  report.offset_reestimated = score(measured, tail.total(with_offset_fitted(result.model, tail, measured)));
  const Eigen::VectorXd residual = measured - simulated;
  const int lags = static_cast<int>(std::min<Eigen::Index>(kCorrelationLags, rest - 1));
  report.acf = autocorrelation(residual, lags);
  report.ccf = cross_correlation(residual, picked(record.input, comparison).tail(rest), lags);
  report.ljung_box_p = ljung_box_p(report.acf, static_cast<std::size_t>(rest));
  result.model.validation = report;
}

void fill_parameters(FitResult& result, const ComparedRecord& compared, const Outcome& outcome,
                     const LinearPart& linear, const LinearSolution& solution, const StructureOptions& structure,
                     const ProfileSearch* profile) {
  const TransferFunction& g = result.model.transfer_function;
  Parametrisation plain = Parametrisation::plain(structure, g);
  const OutputError problem(compared, plain, linear);
  ParameterCorrelation correlation;
  const Eigen::MatrixXd derivatives = problem.derivatives(plain.start(), solution, correlation.names);
  const ResidualModel residual = residual_model(outcome.best.point.residual);
  const Uncertainty known = uncertainty(derivatives, correlation.names, residual);
  for (Eigen::Index i = 0; i < known.correlation.rows(); ++i) {
    correlation.matrix.emplace_back(known.correlation.row(i).begin(), known.correlation.row(i).end());
  }
  correlation.indistinguishable = known.indistinguishable;
  result.model.estimation->information =
      information(outcome.best.point.cost / static_cast<double>(outcome.best.point.residual.size()), outcome.free,
                  residual.effective_samples);

  std::vector<Interval> reach;
  if (profile != nullptr) {
    // With several numerator terms the bias does not enter linearly.
    const bool bias_coordinate = outcome.variant.bias_coordinate || (linear.solve_bias && linear.numerator.size() > 1);
    LinearPart searched = linear;
    searched.solve_bias = linear.solve_bias && !bias_coordinate;
    const ReportedOptimum optimum{.compared = compared,
                                  .plain = problem,
                                  .structure = structure,
                                  .scale = profile->scale,
                                  .linear = searched,
                                  .bias_bound = bias_coordinate ? profile->largest_input : 0.0,
                                  .solution = solution,
                                  .cost = outcome.best.point.cost,
                                  .names = correlation.names};
    reach = intervals(optimum, known, profile->executor);
  }
  const auto add = [&](const std::string& name, double value) {
    ParameterEstimate p{name, value, 0.0, value, value, true};
    const auto at = std::find(correlation.names.begin(), correlation.names.end(), name);
    if (at != correlation.names.end()) {
      const auto i = static_cast<Eigen::Index>(at - correlation.names.begin());
      p.fixed = false;
      const auto& lost = known.indistinguishable;
      const bool is_lost = std::find(lost.begin(), lost.end(), name) != lost.end();
      p.std = is_lost ? std::numeric_limits<double>::infinity() : std::sqrt(known.covariance(i, i));
      const double half_width = known.interval_factor * p.std;
      const Interval straight{value - half_width, value + half_width};
      const Interval interval = reach.empty() ? straight : reach[static_cast<std::size_t>(i)];
      p.lower95 = interval.lower;
      p.upper95 = interval.upper;
    }
    result.model.parameters.push_back(p);
  };
  for (std::size_t j = 0; j < g.numerator.size(); ++j)
    add(numerator_name(j, g.numerator.size()), g.numerator[j].coefficient);
  for (std::size_t i = g.denominator.size(); i-- > 0;) add(coefficient_name(i), g.denominator[i].coefficient);
  if (structure.kind == StructureKind::commensurate) {
    add("q", g.denominator[1].order);
  } else if (structure.kind != StructureKind::io) {
    for (std::size_t i = g.denominator.size(); i-- > 0;) add(order_name(i), g.denominator[i].order);
    add("b0", g.numerator[0].order);
  }
  add("delay_s", g.delay_s);
  add("input_bias", result.model.input_bias);
  add("initial_output", result.model.initial_output);
  for (std::size_t i = 0; i < result.model.initial_state.size(); ++i) add(state_name(i), result.model.initial_state[i]);
  for (std::size_t i = 0; i < result.model.past_input.size(); ++i)
    add(past_input_name(i), result.model.past_input[i].value);
  result.covariance = {correlation.names, known.covariance};
  result.model.estimation->correlation = std::move(correlation);
}

}  // namespace eha::ident
