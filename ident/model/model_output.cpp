// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/model_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.hpp"
#include "ident/fractional/grunwald_letnikov.hpp"
#include "ident/fractional/held_response.hpp"
#include "ident/fractional/stability.hpp"
#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/model/grey_box_output.hpp"

namespace eha::ident {
namespace {

constexpr std::size_t kMostPast = 100;  // times the rows simulated; a transform of that length still fits
// A column this small beside the columns that it depends on is not solved for.
constexpr double kOffsetRank = 1e-10;
constexpr double kEndless_rows = 1e15;  // fits an index

/// Free responses s^i/D, i = 0.., as step responses of s^(i+1)/D.
Eigen::MatrixXd state_responses(const Model& model, const OutputSelection& selection) {
  const auto shared = HeldResponse::of(selection);
  const HeldResponse& response = *shared;
  std::vector<std::vector<Term>> numerators;
  for (std::size_t i = 0; i < model.initial_state.size(); ++i)
    numerators.push_back({{1.0, static_cast<double>(i + 1)}});
  const InputSpectrum step = response.step_spectrum();
  std::vector<ResponseRequest> requests;
  for (std::size_t i = 0; i < model.initial_state.size(); ++i) requests.push_back({i, &step, AtJump::after});
  return response.respond({model.transfer_function, numerators, {}}, 0.0, requests);
}

/// Responses to one unit of input in each window before t = 0; the windows' edges need not be sampling instants.
Eigen::MatrixXd past_responses(const Model& model, OutputSelection selection) {
  const auto rows_before = [&](double t_s) {
    return static_cast<std::size_t>(std::min(kEndless_rows, std::ceil(-t_s / selection.step_s - 1e-9)));
  };
  std::size_t before = 0;
  for (const PastInput& window : model.past_input) before = std::max(before, rows_before(window.from_s));
  if (before > kMostPast * (selection.samples + 1)) {
    throw ConfigError(fmt::format("past_input: expected windows that reach back at most {} times the record, got {} s",
                                  kMostPast, -model.past_input.back().from_s));
  }
  selection.samples += before;
  selection.first += before;
  const auto shared = HeldResponse::of(selection);
  const HeldResponse& response = *shared;
  const TransferColumns columns(model.transfer_function, {model.transfer_function.numerator}, {});
  const auto to_step_at = [&](double t_s) -> Eigen::VectorXd {
    const std::size_t rows = rows_before(t_s);
    const double late_s = std::max(0.0, static_cast<double>(rows) * selection.step_s + t_s);
    const InputSpectrum step = response.step_spectrum(before - rows);
    const ResponseRequest request{0, &step};
    return response.respond(columns, model.transfer_function.delay_s + late_s, {&request, 1});
  };
  Eigen::MatrixXd responses(static_cast<Eigen::Index>(selection.count),
                            static_cast<Eigen::Index>(model.past_input.size()));
  for (std::size_t k = 0; k < model.past_input.size(); ++k) {
    const PastInput& window = model.past_input[k];
    responses.col(static_cast<Eigen::Index>(k)) = to_step_at(window.from_s) - to_step_at(window.to_s);
  }
  return responses;
}

Eigen::MatrixXd free_responses(const Model& model, const OutputSelection& selection) {
  const Eigen::Index rows = static_cast<Eigen::Index>(selection.count);
  const Eigen::MatrixXd states =
      model.initial_state.empty() ? Eigen::MatrixXd(rows, 0) : state_responses(model, selection);
  const Eigen::MatrixXd past = model.past_input.empty() ? Eigen::MatrixXd(rows, 0) : past_responses(model, selection);
  Eigen::MatrixXd all(rows, states.cols() + past.cols());
  all << states, past;
  return all;
}

/// The initial state, then the past input.
Eigen::VectorXd free_values(const Model& model) {
  std::vector<double> values = model.initial_state;
  for (const PastInput& window : model.past_input) values.push_back(window.value);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

/// Returns the input of G.
Eigen::VectorXd driving(const Model& model, const Eigen::Ref<const Eigen::VectorXd>& input) {
  if (model.input_map) return mapped(*model.input_map, input);
  return input.array() + model.input_bias;
}

bool is_at_rest(const Model& model) { return model.initial_state.empty() && model.past_input.empty(); }

}  // namespace

Eigen::VectorXd simulate(const Model& model, const Eigen::Ref<const Eigen::VectorXd>& input, double step_s,
                         SimulationMethod method) {
  if (model.grey_box) {
    if (method != SimulationMethod::exact) {
      throw ConfigError(fmt::format("grey_box: {} is simulated by the method exact alone", model.grey_box->kind->name));
    }
    return grey_box_output(model, driving(model, input), step_s).array() + model.initial_output;
  }
  Eigen::VectorXd y = simulate(model.transfer_function, driving(model, input), step_s, method);
  y.array() += model.initial_output;
  if (!is_at_rest(model) && input.size() > 0) {
    const auto samples = static_cast<std::size_t>(input.size());
    y += free_responses(model, {samples, step_s, 0, 1, samples, {}}) * free_values(model);
  }
  return y;
}

Eigen::VectorXd ModelOutput::total(const Model& model) const {
  Eigen::VectorXd y = forced.array() + model.initial_output;
  if (free.cols() > 0) y += free * free_values(model);
  return y;
}

ModelOutput ModelOutput::at(const MeasuredRows& rows) const { return {rows.of(forced), rows.of_columns(free)}; }

OutputOnRecord::OutputOnRecord(const Record& record, const Comparison& comparison)
    : record_(record), comparison_(comparison), measured_rows_(record, comparison) {}

ModelOutput OutputOnRecord::of(const Model& model) {
  if (model.grey_box) {
    return {picked(grey_box_output(model, driving(model, record_.input), record_.step_s), comparison_), {}};
  }
  if (grows(model.transfer_function)) {
    const Eigen::VectorXd input = driving(model, record_.input);
    return {picked(simulate_gl_directly(model.transfer_function, input, record_.step_s), comparison_), {}};
  }
  const HeldResponse& held = held_response();
  InputSpectrum driven;
  if (model.input_map) {
    driven = spectrum_of(driving(model, record_.input));
  } else {
    if (input_.empty()) input_ = spectrum_of(record_.input);
    driven = input_;
    // The bias is a step at the first row.
    const InputSpectrum step = held.step_spectrum();
    for (std::size_t j = 0; j < driven.size(); ++j) driven[j] += model.input_bias * step[j];
  }
  const ResponseRequest request{0, &driven};
  const TransferColumns columns(model.transfer_function, {model.transfer_function.numerator}, {});
  ModelOutput output{held.respond(columns, model.transfer_function.delay_s, {&request, 1}), {}};
  if (!is_at_rest(model)) output.free = free_responses(model, held.selection());
  return output;
}

Eigen::VectorXd OutputOnRecord::response(const TransferFunction& g, const Eigen::Ref<const Eigen::VectorXd>& signal) {
  const InputSpectrum driven = spectrum_of(signal);
  const ResponseRequest request{0, &driven};
  return held_response().respond(TransferColumns(g, {g.numerator}, {}), g.delay_s, {&request, 1});
}

const HeldResponse& OutputOnRecord::held_response() {
  if (!response_) {
    response_ = HeldResponse::of({static_cast<std::size_t>(record_.input.size()), record_.step_s, comparison_.first,
                                  comparison_.every, comparison_.count, comparison_.taps});
  }
  return *response_;
}

InputSpectrum OutputOnRecord::spectrum_of(const Eigen::Ref<const Eigen::VectorXd>& input) {
  // If a filter leaves low frequencies only, a tenth of the memory suffices.
  const HeldResponse& held = held_response();
  return comparison_.taps.empty() ? held.input_spectrum(input) : held.quick_input_spectrum(input);
}

Model with_offset_fitted(const Model& model, const ModelOutput& output, const Eigen::VectorXd& measured) {
  const auto states = std::min(output.free.cols(), static_cast<Eigen::Index>(model.initial_state.size()));
  Eigen::VectorXd rest = measured - output.forced;
  if (output.free.cols() > states) {
    // Past windows keep their values: free ones would fit the beginning of any record.
    const Eigen::Index windows = output.free.cols() - states;
    rest -= output.free.rightCols(windows) * free_values(model).tail(windows);
  }
  Eigen::MatrixXd columns(measured.size(), states + 1);
  columns.col(0).setOnes();
  if (states > 0) columns.rightCols(states) = output.free.leftCols(states);
  const Eigen::VectorXd scale = columns.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  const Eigen::VectorXd solved = scale.cwiseProduct(solve_ranked(columns * scale.asDiagonal(), rest, kOffsetRank));
  Model fitted = model;
  fitted.initial_output = solved[0];
  for (Eigen::Index i = 0; i < states; ++i) fitted.initial_state[static_cast<std::size_t>(i)] = solved[i + 1];
  return fitted;
}

}  // namespace eha::ident
