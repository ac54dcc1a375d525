// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/record_start.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "ident/fractional/stability.hpp"
#include "ident/grey_box/grey_box_kind.hpp"
#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/signal/decimation.hpp"

namespace eha::ident {
namespace {

constexpr double kSettlings = 5.0;    // of the slowest mode within the record that estimated it
constexpr double kShows = 1e-6;       // of the response at rest: a smaller start is not seen by the compared rows
constexpr double kPastRecords = 2.0;  // length of the past at rest behind a map
constexpr double kDifference = 1e-4;  // step of a derivative by a state, of the output's range

std::vector<Term> by_order(std::vector<Term> terms) {
  std::stable_sort(terms.begin(), terms.end(), [](const Term& a, const Term& b) { return a.order < b.order; });
  return terms;
}

/// G at frequency 0 of a model that comes to rest.
double gain_at_rest(const Model& model) {
  const Term lowest = by_order(model.transfer_function.numerator).front();
  return lowest.order > 0.0 ? 0.0
                            : lowest.coefficient / by_order(model.transfer_function.denominator).front().coefficient;
}

Model with_past(Model model, double from_s, double value) {
  model.past_input = {{from_s, 0.0, value}};
  return model;
}

const ParameterEstimate* find(const Model& model, ParameterRole role) {
  const auto at = std::find_if(model.parameters.begin(), model.parameters.end(),
                               [&](const ParameterEstimate& p) { return p.role == role; });
  return at == model.parameters.end() ? nullptr : &*at;
}

/// A grey box with the states at the first row that describe a record best, beside an offset that is left out again:
/// least squares from rest under the first input on, of steps that are halved while they help nothing.
Model with_states_on(const Model& model, OutputOnRecord& outputs) {
  constexpr int kRounds = 5;
  constexpr int kHalvings = 6;
  const Record& record = outputs.record();
  const MeasuredRows& rows = outputs.measured_rows();
  const Eigen::VectorXd measured = rows.of(picked(record.output, outputs.comparison()));
  const auto rest_of = [&](const Model& begun) {
    Eigen::VectorXd rest = measured - rows.of(outputs.of(begun).forced);
    rest.array() -= rest.mean();
    return rest;
  };
  Model begun = begun_at(model, record.input[0]);
  const double move = kDifference * (measured.maxCoeff() - measured.minCoeff());
  Eigen::VectorXd rest = rest_of(begun);
  Eigen::MatrixXd columns(rest.size(), static_cast<Eigen::Index>(begun.initial_state.size()));
  for (int round = 0; round < kRounds && move > 0.0 && rest.allFinite(); ++round) {
    for (Eigen::Index i = 0; i < columns.cols(); ++i) {
      Model moved = begun;
      moved.initial_state[static_cast<std::size_t>(i)] += move;
      columns.col(i) = (rest - rest_of(moved)) / move;
    }
    if (!columns.allFinite()) break;
    Eigen::VectorXd step = solve_ranked(columns, rest, kDifference);
    for (int half = 0; half < kHalvings; ++half, step *= 0.5) {
      Model other = begun;
      for (Eigen::Index i = 0; i < step.size(); ++i) other.initial_state[static_cast<std::size_t>(i)] += step[i];
      const Eigen::VectorXd left = rest_of(other);
      if (!(left.squaredNorm() < rest.squaredNorm())) continue;
      begun = std::move(other);
      rest = left;
      break;
    }
  }
  return begun;
}

}  // namespace

double compared_s(const Model& model) {
  if (!model.estimation) return 0.0;
  return static_cast<double>(model.estimation->score.samples) * model.estimation->compared_step_s.value_or(0.0);
}

bool comes_to_rest(const Model& model) {
  if (model.grey_box || !model.estimation || model.transfer_function.denominator.empty()) return false;
  if (grows(model.transfer_function)) return false;
  const double record_s = compared_s(model);
  const std::vector<Term> d = by_order(model.transfer_function.denominator);
  if (d.front().order > 0.0 || model.transfer_function.numerator.empty()) return false;
  return std::all_of(d.begin() + 1, d.end(), [&](const Term& term) {
    const double ratio = std::abs(d.front().coefficient / term.coefficient);
    return std::pow(ratio, 1.0 / term.order) * record_s > kSettlings;
  });
}

bool begins_at_a_level(const Model& model) {
  if (model.grey_box) return model.grey_box->kind->at_rest != nullptr;
  return !model.input_map && model.initial_state.empty() && model.past_input.empty() && comes_to_rest(model);
}

bool has_straight_map(const Model& model) {
  if (!model.input_map || !comes_to_rest(model)) return false;
  const ParameterEstimate* dead_band = find(model, ParameterRole::dead_band);
  const ParameterEstimate* ratio = find(model, ParameterRole::negative_gain_ratio);
  return dead_band != nullptr && ratio != nullptr && dead_band->lower95 <= 0.0 && ratio->lower95 <= 1.0 &&
         ratio->upper95 >= 1.0;
}

Model begun_at(const Model& model, double level) {
  Model begun = model;
  if (model.grey_box) {
    begun.initial_state.resize(model.grey_box->kind->states);
    model.grey_box->kind->at_rest(model.grey_box->values.data(), level + model.input_bias, begun.initial_state.data());
    return begun;
  }
  begun.initial_output += gain_at_rest(model) * (model.input_bias + level);
  begun.input_bias = -level;
  return begun;
}

Model begun_on(const Model& model, OutputOnRecord& outputs) {
  if (model.grey_box) return begins_at_a_level(model) ? with_states_on(model, outputs) : model;
  const bool is_at_rest = model.initial_state.empty() && model.past_input.empty();
  if (!is_at_rest || model.procedure == "paper" || !comes_to_rest(model)) return model;
  const Record& record = outputs.record();
  const double past_s = kPastRecords * record.step_s * static_cast<double>(record.input.size());
  const double at_rest = gain_at_rest(model);
  // The response to one unit before the first row, which decays from there.
  Eigen::VectorXd decay;
  if (model.input_map) {
    decay = outputs.of(with_past(model, -past_s, 1.0)).free.col(0);
  } else {
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(record.input.size());
    decay = at_rest - outputs.response(model.transfer_function, ones).array();
  }
  if (decay.cwiseAbs().maxCoeff() <= kShows * std::abs(at_rest)) return model;
  const MeasuredRows& rows = outputs.measured_rows();
  const Eigen::VectorXd rest = rows.of(picked(record.output, outputs.comparison()) - outputs.of(model).forced);
  decay = rows.of(decay);
  // Both less their means: the offset is estimated with it.
  const Eigen::VectorXd centred = decay.array() - decay.mean();
  if (!(centred.norm() > 0.0)) return model;
  const double before = centred.dot(rest) / centred.squaredNorm();
  return model.input_map ? with_past(model, -past_s, before) : begun_at(model, before - model.input_bias);
}

}  // namespace eha::ident
