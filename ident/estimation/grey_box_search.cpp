// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/grey_box_search.hpp"

#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/NonLinearOptimization>

#include "ident/model/grey_box_output.hpp"
#include "ident/structure/parameter_requests.hpp"

namespace eha::ident {
namespace {

constexpr double kDifference = 1e-6;      // relative step of a derivative
constexpr double kFarOff = 1e6;           // times the output's spread, for a trial that is not finite
constexpr double kTolerance = 1e-8;       // relative, of cost and step
constexpr double kRoughTolerance = 1e-5;  // the same from afar, where each row then finds the end
constexpr std::size_t kStepsBack = 5;     // whose fall of the cost tells how far a search may still come
constexpr double kLeastLogarithm = -50;   // of a positive value

double& value_of(Model& model, const ParameterKey& key) {
  switch (key.role) {
    case ParameterRole::grey_box:
      return model.grey_box.value().values[key.index];
    case ParameterRole::input_bias:
      return model.input_bias;
    case ParameterRole::delay:
      return model.transfer_function.delay_s;
    case ParameterRole::initial_state:
      return model.initial_state[key.index];
    default:
      return model.initial_output;
  }
}

/// Means of so many values each, the last one repeated.
Eigen::VectorXd means_of(const Eigen::VectorXd& values, Eigen::Index together) {
  const Eigen::Index count = (values.size() + together - 1) / together;
  Eigen::VectorXd means(count + 1);
  for (Eigen::Index k = 0; k < count; ++k) {
    means[k] = values.segment(k * together, std::min(together, values.size() - k * together)).mean();
  }
  means[count] = means[count - 1];
  return means;
}

/// Straight lines between values that are so many rows apart.
Eigen::VectorXd in_between(const Eigen::VectorXd& values, Eigen::Index apart, Eigen::Index rows) {
  Eigen::VectorXd all(rows);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const Eigen::Index k = row / apart;
    const double share = static_cast<double>(row - k * apart) / static_cast<double>(apart);
    all[row] = values[k] + share * (values[k + 1] - values[k]);
  }
  return all;
}

}  // namespace

GreyBoxSearch::GreyBoxSearch(const PreparedRecord& prepared, const StructureOptions& asked, Eigen::Index rows_together)
    : asked_(asked),
      kind_(*asked.structure.grey_box.value().kind),
      rows_(prepared.rows.comparison),
      estimates_start_(asked.initial_state == InitialState::estimated ||
                       (asked.initial_state == InitialState::automatic && kind_.estimates_start)),
      rows_together_(rows_together) {
  rows_.count = prepared.rows.estimating;
  // Rows after the window of the last compared one cannot reach it.
  const auto needed = static_cast<Eigen::Index>(prepared.rows.last + rows_.taps.size() / 2 + 1);
  record_ = prepared.record;
  record_.input.conservativeResize(std::min(needed, record_.input.size()));
  record_.output.conservativeResize(record_.input.size());
  if (rows_together_ > 1) means_ = means_of(record_.input, rows_together_);
  kept_ = MeasuredRows(record_, rows_);
  measured_ = kept_.of(picked(record_.output, rows_));
  spread_ = std::sqrt((measured_.array() - measured_.mean()).square().mean());
  choose_coordinates();
}

std::vector<Model> GreyBoxSearch::starts(const Model& linear) const {
  const double mean_in = record_.input.mean();
  GreyBoxStart from;
  for (const Term& term : linear.transfer_function.denominator) {
    const auto order = static_cast<std::size_t>(std::lround(term.order));
    if (order < from.linear.denominator.size()) from.linear.denominator[order] = std::abs(term.coefficient);
  }
  from.linear.gain = linear.transfer_function.numerator.front().coefficient;
  from.input_rms = std::sqrt((record_.input.array() - mean_in).square().mean());
  Model model = linear;
  model.parameters.clear();
  if (kind_.bias_is_reference) {
    const double dc = from.linear.gain / from.linear.denominator[0];
    model.initial_output += dc * (linear.input_bias + mean_in);
    if (!std::isfinite(model.initial_output)) model.initial_output = measured_.mean();
    model.input_bias = -mean_in;
  }
  if (!estimates_start_)
    model.initial_output = std::clamp(model.initial_output, measured_.minCoeff(), measured_.maxCoeff());
  from.lowest_out = record_.output.minCoeff() - model.initial_output;
  from.greatest_out = record_.output.maxCoeff() - model.initial_output;
  model.initial_state.clear();
  if (estimates_start_) {
    model.initial_state.assign(kind_.states, 0.0);
    model.initial_state[0] = record_.output[0] - model.initial_output;
  }
  if (!kind_.estimates_start) model.initial_output = record_.output[0];
  std::vector<Model> all;
  for (std::vector<double>& values : kind_.starts(from)) {
    model.grey_box = GreyBox{&kind_, std::move(values)};
    for (const StructureParameter& parameter : asked_.structure.grey_box->parameters) {
      const ParameterRequest* request = find_request(asked_, parameter);
      if (request != nullptr && request->start) model.grey_box->values[parameter.key.index] = *request->start;
    }
    const ParameterRequest* bias = find_request(asked_, asked_.structure.input_map.bias);
    if (bias != nullptr && bias->start) model.input_bias = *bias->start;
    const ParameterRequest* offset = find_request(asked_, asked_.structure.initial_output);
    if (offset != nullptr && offset->start) model.initial_output = *offset->start;
    all.push_back(begun_at(model));
  }
  return all;
}

Model GreyBoxSearch::begun_at(Model model) const {
  model.initial_state.resize(estimates_start_ ? kind_.states : model.initial_state.size(), 0.0);
  // No logarithm leads away from 0.
  if (is_estimated(asked_, asked_.structure.delay) && !(model.transfer_function.delay_s > 0.0)) {
    model.transfer_function.delay_s = record_.step_s;
  }
  return model;
}

Eigen::VectorXd GreyBoxSearch::simulated(const Model& model) const {
  if (rows_together_ == 1) {
    return grey_box_output(model, record_.input.array() + model.input_bias, record_.step_s);
  }
  const double step_s = record_.step_s * static_cast<double>(rows_together_);
  return in_between(grey_box_output(model, means_.array() + model.input_bias, step_s), rows_together_,
                    record_.input.size());
}

Eigen::VectorXd GreyBoxSearch::residual(const Model& model) const {
  Eigen::VectorXd error = kept_.of(picked(simulated(model), rows_)) - measured_;
  error.array() += model.initial_output;
  if (!error.allFinite()) error.setConstant(kFarOff * spread_);
  return error;
}

Eigen::VectorXd GreyBoxSearch::place(const Model& model) const {
  Eigen::VectorXd theta(static_cast<Eigen::Index>(coordinates_.size()));
  Model copy = model;
  for (std::size_t i = 0; i < coordinates_.size(); ++i) {
    const double value = value_of(copy, coordinates_[i].key);
    theta[static_cast<Eigen::Index>(i)] =
        coordinates_[i].is_logarithm ? std::log(std::max(value, std::exp(kLeastLogarithm))) : value;
  }
  return theta;
}

void GreyBoxSearch::move_to(Model& model, const Eigen::VectorXd& theta) const {
  for (std::size_t i = 0; i < coordinates_.size(); ++i) {
    const double at = theta[static_cast<Eigen::Index>(i)];
    value_of(model, coordinates_[i].key) = coordinates_[i].is_logarithm ? std::exp(at) : at;
  }
}

Eigen::MatrixXd GreyBoxSearch::rough_derivatives(const Model& model, const Eigen::VectorXd& theta,
                                                 const Eigen::VectorXd& at) const {
  Eigen::MatrixXd columns(measured_.size(), theta.size());
  Model moved = model;
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    const double step = step_of(i, theta);
    Eigen::VectorXd to = theta;
    to[i] += step;
    move_to(moved, to);
    columns.col(i) = (residual(moved) - at) / step;
  }
  return columns;
}

Eigen::MatrixXd GreyBoxSearch::derivatives(const Model& model, bool by_coordinate) const {
  Eigen::MatrixXd columns(measured_.size(), static_cast<Eigen::Index>(coordinates_.size()));
  const Eigen::VectorXd theta = place(model);
  for (Eigen::Index i = 0; i < columns.cols(); ++i) {
    const GreyBoxCoordinate& coordinate = coordinates_[static_cast<std::size_t>(i)];
    const double step = step_of(i, theta);
    const auto moved = [&](double by) {
      Model copy = model;
      Eigen::VectorXd to = theta;
      to[i] += by;
      move_to(copy, to);
      return residual(copy);
    };
    columns.col(i) = (moved(step) - moved(-step)) / (2.0 * step);
    Model copy = model;
    if (!by_coordinate && coordinate.is_logarithm) columns.col(i) /= value_of(copy, coordinate.key);
  }
  return columns;
}

double GreyBoxSearch::step_of(Eigen::Index i, const Eigen::VectorXd& theta) const {
  const GreyBoxCoordinate& coordinate = coordinates_[static_cast<std::size_t>(i)];
  return coordinate.is_logarithm ? kDifference : kDifference * std::max(std::abs(theta[i]), scale_of(coordinate));
}

double GreyBoxSearch::scale_of(const GreyBoxCoordinate& coordinate) const {
  return coordinate.key.role == ParameterRole::input_bias || coordinate.key.role == ParameterRole::delay
             ? std::max(1e-3, 1e-2 * record_.step_s)
             : spread_;
}

void GreyBoxSearch::choose_coordinates() {
  const Structure& structure = asked_.structure;
  for (const StructureParameter& parameter : structure.grey_box->parameters) {
    if (is_estimated(asked_, parameter)) {
      coordinates_.push_back({parameter.key, kind_.parameters[parameter.key.index].positive});
    }
  }
  for (const StructureParameter* parameter : {&structure.delay, &structure.input_map.bias, &structure.initial_output}) {
    if (is_estimated(asked_, *parameter)) coordinates_.push_back({parameter->key, parameter == &structure.delay});
  }
  if (!estimates_start_) return;
  for (std::size_t i = 0; i < kind_.states; ++i) coordinates_.push_back({state_key(i), false});
}

namespace {

/// The search as Eigen's minimiser, a port of MINPACK's lmder, wants it.
struct Functor {
  const GreyBoxSearch& search;
  const Model& start;
  bool rough;
  Eigen::VectorXd last_theta = {};  ///< of the last trial
  Eigen::VectorXd last_error = {};
  int further = 0;  ///< trials that derivatives took

  [[nodiscard]] int values() const { return static_cast<int>(search.measured().size()); }
  int operator()(const Eigen::VectorXd& theta, Eigen::VectorXd& error) {
    Model model = start;
    search.move_to(model, theta);
    error = search.residual(model);
    if (rough) {
      last_theta = theta;
      last_error = error;
    }
    return 0;
  }
  int df(const Eigen::VectorXd& theta, Eigen::MatrixXd& jacobian) {
    Model model = start;
    search.move_to(model, theta);
    if (rough) {
      if (last_theta != theta) {
        last_error = search.residual(model);
        last_theta = theta;
        ++further;
      }
      jacobian = search.rough_derivatives(model, theta, last_error);
    } else {
      jacobian = search.derivatives(model, true);
    }
    return jacobian.allFinite() ? 0 : -1;
  }
};

/// Whether a search will not come below a cost, were each of the trials that are left to lower it as much as the last
/// ones did. @param costs  after each step, the latest last
bool is_hopeless(const std::vector<double>& costs, int trials_left, double most_cost) {
  if (costs.size() <= kStepsBack || !(costs.back() > most_cost)) return false;
  const double fall = costs.back() / costs[costs.size() - 1 - kStepsBack];
  return costs.back() * std::pow(fall, static_cast<double>(trials_left) / static_cast<double>(kStepsBack)) > most_cost;
}

}  // namespace

GreyBoxSearch::End GreyBoxSearch::minimised(const Model& start, const Effort& effort, double most_cost) const {
  using Status = Eigen::LevenbergMarquardtSpace::Status;
  Functor functor{*this, start, effort.rough};
  Eigen::LevenbergMarquardt<Functor> minimiser(functor);
  minimiser.parameters.maxfev = effort.trials;
  const double tolerance = rows_together_ > 1 ? kRoughTolerance : kTolerance;
  minimiser.parameters.ftol = tolerance;
  minimiser.parameters.xtol = tolerance;
  Eigen::VectorXd theta = place(start);
  Status status = minimiser.minimizeInit(theta);
  std::vector<double> costs;
  bool is_left = false;
  while (!is_left && (status == Status::Running || status == Status::NotStarted)) {
    status = minimiser.minimizeOneStep(theta);
    costs.push_back(minimiser.fnorm * minimiser.fnorm);
    const int left = effort.trials - static_cast<int>(minimiser.nfev) + effort.trials_left;
    is_left = is_hopeless(costs, left, most_cost);
  }
  End end{start, minimiser.fnorm * minimiser.fnorm};
  if (!std::isfinite(end.cost)) end.cost = std::numeric_limits<double>::infinity();  // sorted last
  move_to(end.model, theta);
  const std::size_t a_derivative = (effort.rough ? 1 : 2) * coordinates_.size();
  end.evaluations = static_cast<std::size_t>(minimiser.nfev) + static_cast<std::size_t>(functor.further) +
                    static_cast<std::size_t>(minimiser.njev) * a_derivative;
  end.converged = status != Status::TooManyFunctionEvaluation && status != Status::UserAsked &&
                  status != Status::ImproperInputParameters && status != Status::Running;
  end.is_hopeless = is_left || (end.converged && end.cost > most_cost);
  return end;
}

}  // namespace eha::ident
