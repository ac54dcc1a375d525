// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/grey_box_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <unsupported/Eigen/NonLinearOptimization>

#include "core/error.hpp"
#include "ident/estimation/fit_report.hpp"
#include "ident/estimation/known_starts.hpp"
#include "ident/fractional/stability.hpp"
#include "ident/model/grey_box_output.hpp"
#include "ident/structure/parameter_requests.hpp"
#include "ident/uncertainty/covariance.hpp"
#include "ident/uncertainty/information.hpp"

namespace eha::ident {
namespace {

constexpr double kDifference = 1e-6;  // relative step of a derivative
constexpr double kFarOff = 1e6;       // times the output's spread, for a trial that is not finite
constexpr int kRoughBoxSteps = 15;    // trials of every start
constexpr int kMostBoxSteps = 200;    // of those followed
constexpr std::size_t kMostBoxesFollowed = 3;
constexpr double kTolerance = 1e-8;      // relative, of cost and step
constexpr double kLeastLogarithm = -50;  // of a positive value
constexpr double kUnseen = 0.01;         // of a row: the record shows no shorter time constant

/// The linear structure of a kind, without the requests for what it does not have.
StructureOptions linear_of(const StructureOptions& asked, const GreyBoxKind& kind) {
  StructureOptions linear;
  linear.name = asked.name;
  linear.structure = kind.integrates ? structures::integrator_lag() : structures::io();
  linear.structure.delay = asked.structure.delay;
  for (const ParameterRequest& request : asked.parameters) {
    if (request.name == asked.structure.delay.key.name) linear.parameters.push_back(request);
  }
  return linear;
}

/// What is estimated of a model, as coordinates.
struct GreyBoxCoordinate {
  ParameterKey key;
  bool is_logarithm = false;
};

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

class GreyBoxSearch {
 public:
  GreyBoxSearch(const PreparedRecord& prepared, const StructureOptions& asked)
      : asked_(asked),
        kind_(*asked.structure.grey_box.value().kind),
        rows_(prepared.rows.comparison),
        estimates_start_(asked.initial_state == InitialState::estimated ||
                         (asked.initial_state == InitialState::automatic && kind_.estimates_start)) {
    rows_.count = prepared.rows.estimating;
    // Rows after the window of the last compared one cannot reach it.
    const auto needed = static_cast<Eigen::Index>(prepared.rows.last + rows_.taps.size() / 2 + 1);
    record_ = prepared.record;
    record_.input.conservativeResize(std::min(needed, record_.input.size()));
    record_.output.conservativeResize(record_.input.size());
    kept_ = MeasuredRows(record_, rows_);
    measured_ = kept_.of(picked(record_.output, rows_));
    spread_ = std::sqrt((measured_.array() - measured_.mean()).square().mean());
    choose_coordinates();
  }

  [[nodiscard]] const std::vector<GreyBoxCoordinate>& coordinates() const { return coordinates_; }
  [[nodiscard]] const Eigen::VectorXd& measured() const { return measured_; }

  /// Models worth a start. @param linear  fitted to the same rows
  [[nodiscard]] std::vector<Model> starts(const Model& linear) const {
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

  /// A model of the kind with the states and the dead time that the search moves.
  [[nodiscard]] Model begun_at(Model model) const {
    model.initial_state.resize(estimates_start_ ? kind_.states : model.initial_state.size(), 0.0);
    // No logarithm leads away from 0.
    if (is_estimated(asked_, asked_.structure.delay) && !(model.transfer_function.delay_s > 0.0)) {
      model.transfer_function.delay_s = record_.step_s;
    }
    return model;
  }

  /// Model less measured at the estimating rows; far off where it is not finite.
  [[nodiscard]] Eigen::VectorXd residual(const Model& model) const {
    const Eigen::VectorXd v = record_.input.array() + model.input_bias;
    Eigen::VectorXd error = kept_.of(picked(grey_box_output(model, v, record_.step_s), rows_)) - measured_;
    error.array() += model.initial_output;
    if (!error.allFinite()) error.setConstant(kFarOff * spread_);
    return error;
  }

  [[nodiscard]] Eigen::VectorXd place(const Model& model) const {
    Eigen::VectorXd theta(static_cast<Eigen::Index>(coordinates_.size()));
    Model copy = model;
    for (std::size_t i = 0; i < coordinates_.size(); ++i) {
      const double value = value_of(copy, coordinates_[i].key);
      theta[static_cast<Eigen::Index>(i)] =
          coordinates_[i].is_logarithm ? std::log(std::max(value, std::exp(kLeastLogarithm))) : value;
    }
    return theta;
  }
  void move_to(Model& model, const Eigen::VectorXd& theta) const {
    for (std::size_t i = 0; i < coordinates_.size(); ++i) {
      const double at = theta[static_cast<Eigen::Index>(i)];
      value_of(model, coordinates_[i].key) = coordinates_[i].is_logarithm ? std::exp(at) : at;
    }
  }

  /// Derivatives of the simulated output by what is estimated: by central differences.
  [[nodiscard]] Eigen::MatrixXd derivatives(const Model& model, bool by_coordinate) const {
    Eigen::MatrixXd columns(measured_.size(), static_cast<Eigen::Index>(coordinates_.size()));
    const Eigen::VectorXd theta = place(model);
    for (Eigen::Index i = 0; i < columns.cols(); ++i) {
      const GreyBoxCoordinate& coordinate = coordinates_[static_cast<std::size_t>(i)];
      const double step =
          coordinate.is_logarithm ? kDifference : kDifference * std::max(std::abs(theta[i]), scale_of(coordinate));
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

  /// Least squares from a start. @returns nothing if it ends at a model that is not finite
  struct End {
    Model model;
    double cost = std::numeric_limits<double>::infinity();
    bool converged = false;
    std::size_t evaluations = 0;
  };
  [[nodiscard]] End minimised(const Model& start, int most_steps) const;

 private:
  [[nodiscard]] double scale_of(const GreyBoxCoordinate& coordinate) const {
    return coordinate.key.role == ParameterRole::input_bias || coordinate.key.role == ParameterRole::delay
               ? std::max(1e-3, 1e-2 * record_.step_s)
               : spread_;
  }

  void choose_coordinates() {
    const Structure& structure = asked_.structure;
    for (const StructureParameter& parameter : structure.grey_box->parameters) {
      if (is_estimated(asked_, parameter)) {
        coordinates_.push_back({parameter.key, kind_.parameters[parameter.key.index].positive});
      }
    }
    for (const StructureParameter* parameter :
         {&structure.delay, &structure.input_map.bias, &structure.initial_output}) {
      if (is_estimated(asked_, *parameter)) coordinates_.push_back({parameter->key, parameter == &structure.delay});
    }
    if (!estimates_start_) return;
    for (std::size_t i = 0; i < kind_.states; ++i) coordinates_.push_back({state_key(i), false});
  }

  const StructureOptions& asked_;
  const GreyBoxKind& kind_;
  Comparison rows_;
  bool estimates_start_;
  Record record_;
  MeasuredRows kept_;
  Eigen::VectorXd measured_;
  double spread_ = 0.0;
  std::vector<GreyBoxCoordinate> coordinates_;
};

/// The search as Eigen's minimiser, a port of MINPACK's lmder, wants it.
struct Functor {
  const GreyBoxSearch& search;
  const Model& start;

  [[nodiscard]] int values() const { return static_cast<int>(search.measured().size()); }
  int operator()(const Eigen::VectorXd& theta, Eigen::VectorXd& error) const {
    Model model = start;
    search.move_to(model, theta);
    error = search.residual(model);
    return 0;
  }
  int df(const Eigen::VectorXd& theta, Eigen::MatrixXd& jacobian) const {
    Model model = start;
    search.move_to(model, theta);
    jacobian = search.derivatives(model, true);
    return jacobian.allFinite() ? 0 : -1;
  }
};

GreyBoxSearch::End GreyBoxSearch::minimised(const Model& start, int most_steps) const {
  Functor functor{*this, start};
  Eigen::LevenbergMarquardt<Functor> minimiser(functor);
  minimiser.parameters.maxfev = most_steps;
  minimiser.parameters.ftol = kTolerance;
  minimiser.parameters.xtol = kTolerance;
  Eigen::VectorXd theta = place(start);
  const auto status = minimiser.minimize(theta);
  End end{start, minimiser.fnorm * minimiser.fnorm, false, 0};
  if (!std::isfinite(end.cost)) end.cost = std::numeric_limits<double>::infinity();  // sorted last
  move_to(end.model, theta);
  end.evaluations =
      static_cast<std::size_t>(minimiser.nfev) + static_cast<std::size_t>(minimiser.njev) * 2 * coordinates_.size();
  end.converged = status != Eigen::LevenbergMarquardtSpace::TooManyFunctionEvaluation &&
                  status != Eigen::LevenbergMarquardtSpace::UserAsked &&
                  status != Eigen::LevenbergMarquardtSpace::ImproperInputParameters;
  return end;
}

/// Holds time constants that are too short for the record to show, as their intervals would be of rounding: moves the
/// model's, and returns what is then asked. Nothing where all are seen.
std::optional<StructureOptions> without_unseen(const StructureOptions& asked, double step_s, Model& model) {
  const GreyBoxKind& kind = *model.grey_box.value().kind;
  StructureOptions held = asked;
  bool any = false;
  for (const StructureParameter& parameter : asked.structure.grey_box.value().parameters) {
    const std::size_t i = parameter.key.index;
    const bool is_time = kind.parameters[i].unit == GreyBoxUnit::seconds;
    if (!is_time || !is_estimated(asked, parameter) || model.grey_box->values[i] > 1.5 * kUnseen * step_s) continue;
    std::erase_if(held.parameters, [&](const ParameterRequest& r) { return r.name == parameter.key.name; });
    held.parameters.push_back({parameter.key.name, true, kUnseen * step_s, {}, {}});
    model.grey_box->values[i] = kUnseen * step_s;
    any = true;
  }
  return any ? std::optional(std::move(held)) : std::nullopt;
}

void check_asked(const StructureOptions& asked, const FitOptions& options) {
  check_requests(asked);
  if (options.procedure == Procedure::paper) {
    throw ConfigError(
        fmt::format("model {}: the paper's procedure has no grey box; leave out one of the two", asked.name));
  }
  for (const ParameterRequest& request : asked.parameters) {
    if (!request.lower && !request.upper) continue;
    throw ConfigError(fmt::format("model {}: parameter {}: bounds are for linear structures; hold it or leave it free",
                                  asked.name, request.name));
  }
}

/// Parameters as the file lists them, with their errors.
void fill_errors(FitResult& result, const GreyBoxSearch& search, const Structure& structure) {
  Model& model = result.model;
  const Eigen::VectorXd residual = -search.residual(model);
  const ResidualModel noise = residual_model(residual);
  ParameterCorrelation correlation;
  std::vector<ParameterKey> keys;
  for (const GreyBoxCoordinate& coordinate : search.coordinates()) {
    keys.push_back(coordinate.key);
    correlation.names.push_back(coordinate.key.name);
  }
  const Uncertainty known = uncertainty(search.derivatives(model, false), correlation.names, noise);
  for (Eigen::Index i = 0; i < known.correlation.rows(); ++i) {
    correlation.matrix.emplace_back(known.correlation.row(i).begin(), known.correlation.row(i).end());
  }
  correlation.indistinguishable = known.indistinguishable;
  model.estimation->information = information(residual, search.measured(), keys.size(), noise.effective_samples);
  model.parameters = listed_values(structure, model);
  add_free_response(model.parameters, model);
  for (ParameterEstimate& p : model.parameters) {
    const auto at = std::find(correlation.names.begin(), correlation.names.end(), p.name);
    if (at == correlation.names.end()) continue;
    const auto i = static_cast<Eigen::Index>(at - correlation.names.begin());
    const auto& lost = known.indistinguishable;
    const bool is_lost = std::find(lost.begin(), lost.end(), p.name) != lost.end();
    p.fixed = false;
    p.std = is_lost ? std::numeric_limits<double>::infinity() : std::sqrt(known.covariance(i, i));
    p.lower95 = std::max(p.value - known.interval_factor * p.std, least_value(p.role));
    p.upper95 = p.value + known.interval_factor * p.std;
  }
  result.covariance = {keys, known.covariance};
  model.estimation->correlation = std::move(correlation);
}

}  // namespace

FitResult fit_grey_box(const PreparedRecord& prepared, const StructureOptions& asked, const FitOptions& options,
                       const Executor& executor, const std::vector<Model>& known) {
  check_asked(asked, options);
  const GreyBoxKind& kind = *asked.structure.grey_box.value().kind;
  const GreyBoxSearch search(prepared, asked);
  const auto same = std::find_if(known.begin(), known.end(),
                                 [&](const Model& model) { return model.grey_box && model.grey_box->kind == &kind; });
  std::vector<Model> starts;
  WorkByStage before;
  if (same != known.end()) {
    starts = {search.begun_at(*same)};
  } else {
    FitOptions plain = options;
    plain.intervals = IntervalMethod::straight;
    plain.search = Search::known;
    const FitResult linear = fit(prepared, linear_of(asked, kind), plain, executor);
    before = linear.work;
    starts = search.starts(linear.model);
  }
  std::vector<GreyBoxSearch::End> ends(starts.size());
  executor(starts.size(), [&](std::size_t k) { ends[k] = search.minimised(starts[k], kRoughBoxSteps); });
  Work work;
  work.local_searches = starts.size();
  for (const GreyBoxSearch::End& end : ends) work.evaluations += end.evaluations;
  std::stable_sort(ends.begin(), ends.end(), [](const auto& one, const auto& other) { return one.cost < other.cost; });
  ends.resize(std::min(ends.size(), kMostBoxesFollowed));
  executor(ends.size(), [&](std::size_t k) { ends[k] = search.minimised(ends[k].model, kMostBoxSteps); });
  std::optional<GreyBoxSearch::End> best;
  for (GreyBoxSearch::End& end : ends) {
    work.evaluations += end.evaluations;
    if (std::isfinite(end.cost) && (!best || end.cost < best->cost)) best = std::move(end);
  }
  if (!best)
    throw NoStableModel(
        fmt::format("model {}: no finite model of this structure was found for the record", asked.name));

  if (const auto held = without_unseen(asked, prepared.record.step_s, best->model)) {
    FitResult result = fit_grey_box(prepared, *held, options, executor, {best->model});
    add(result.work, before);
    result.work["refine"] += work;
    result.model.estimation->evaluations = total(result.work).simulations();
    return result;
  }

  FitResult result = begin_report(prepared.record, asked.name, "default",
                                  linear_form(*best->model.grey_box, best->model.transfer_function.delay_s),
                                  {.work = before,
                                   .termination = best->converged ? "converged" : "evaluation limit",
                                   .converged = best->converged});
  Model& model = result.model;
  if (kind.integrates) model.stability = stability_beside_integrator(model.transfer_function);
  model.grey_box = best->model.grey_box;
  model.input_bias = best->model.input_bias;
  model.initial_output = best->model.initial_output;
  model.initial_state = best->model.initial_state;
  model.structure = asked;
  model.provenance["normalisation"] = "transfer_function is the linear form of the grey box";
  if (kind.bias_is_reference) {
    model.provenance["input_bias"] = "minus the mean input, about which the linear form holds";
  }
  result.estimation_samples = prepared.rows.estimating;
  fill_errors(result, search, asked.structure);
  const Record& record = prepared.record;
  const double compared_step_s = record.step_s * static_cast<double>(prepared.rows.comparison.every);
  model.estimation->compared_step_s = compared_step_s;
  const double duration_s = record.step_s * static_cast<double>(prepared.rows.last + 1);
  model.bode = bode_curve(model, bode_frequencies(duration_s, compared_step_s), result.covariance);
  const bool whole = options.intervals == IntervalMethod::profile;
  fill_validation(result, prepared.facts, prepared.rows.comparison, whole ? Effects::include : Effects::leave_out);
  fill_noise(result, MeasuredRows(record, prepared.rows.comparison), false);
  result.work["refine"] += work;
  model.estimation->evaluations = total(result.work).simulations();
  return result;
}

}  // namespace eha::ident
