// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/grey_box_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "ident/estimation/fit_report.hpp"
#include "ident/estimation/grey_box_search.hpp"
#include "ident/estimation/known_starts.hpp"
#include "ident/estimation/sub_structures.hpp"
#include "ident/fractional/stability.hpp"
#include "ident/model/grey_box_output.hpp"
#include "ident/structure/parameter_requests.hpp"
#include "ident/uncertainty/covariance.hpp"
#include "ident/uncertainty/information.hpp"

namespace eha::ident {
namespace {

constexpr int kRoughBoxSteps = 15;  // trials of every start
constexpr int kMostBoxSteps = 200;  // of those followed
constexpr std::size_t kMostBoxesFollowed = 3;
constexpr int kRoughParts = 4;        // of the step between compared rows, which a search from afar simulates
constexpr int kBoxStepsOfTrial = 30;  // by each row, of one that may not be wanted
constexpr double kAlike = 1.02;       // times the least cost of that search: followed by each row
constexpr double kUnseen = 0.01;      // of a row: the record shows no shorter time constant

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

/// The linear form among models of the same rows; null without one.
const Model* known_linear(const StructureOptions& asked, const GreyBoxKind& kind, const std::vector<Model>& known) {
  const std::string wanted = signature(linear_of(asked, kind));
  const auto is_of_delay = [&](const ParameterRequest& r) { return r.name == asked.structure.delay.key.name; };
  const auto found = std::find_if(known.begin(), known.end(), [&](const Model& model) {
    if (model.grey_box || !model.structure || signature(*model.structure) != wanted) return false;
    const auto& requests = model.structure->parameters;
    return std::all_of(requests.begin(), requests.end(), is_of_delay);
  });
  return found == known.end() ? nullptr : &*found;
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
  } else if (const Model* found = known_linear(asked, kind, known)) {
    starts = search.starts(*found);
  } else {
    FitOptions plain = options;
    plain.intervals = IntervalMethod::straight;
    plain.search = Search::known;
    const FitResult linear = fit(prepared, linear_of(asked, kind), plain, executor);
    before = linear.work;
    starts = search.starts(linear.model);
  }
  std::vector<GreyBoxSearch::End> ends(starts.size());
  const double most_cost = options.most_mse.value_or(std::numeric_limits<double>::infinity()) *
                           static_cast<double>(search.measured().size());
  const auto rows_together = static_cast<Eigen::Index>(prepared.rows.comparison.every) / kRoughParts;
  const GreyBoxSearch from_afar(prepared, asked, std::max<Eigen::Index>(1, rows_together));
  executor(starts.size(), [&](std::size_t k) {
    ends[k] = from_afar.minimised(starts[k], {kRoughBoxSteps, true, kMostBoxSteps}, most_cost);
  });
  Work work;
  work.local_searches = starts.size();
  for (GreyBoxSearch::End& end : ends) work.evaluations += std::exchange(end.evaluations, 0);
  std::stable_sort(ends.begin(), ends.end(), [](const auto& one, const auto& other) { return one.cost < other.cost; });
  ends.resize(std::min(ends.size(), kMostBoxesFollowed));
  std::erase_if(ends, [](const GreyBoxSearch::End& end) { return end.is_hopeless; });
  const auto follow = [&](const GreyBoxSearch& by, int trials) {
    executor(ends.size(), [&](std::size_t k) {
      const std::size_t evaluations = ends[k].evaluations;
      ends[k] = by.minimised(ends[k].model, {trials, false, 0}, most_cost);
      ends[k].evaluations += evaluations;
    });
  };
  if (rows_together > 1 && !ends.empty()) {
    follow(from_afar, kMostBoxSteps);
    const auto least = std::min_element(ends.begin(), ends.end(),
                                        [](const auto& one, const auto& other) { return one.cost < other.cost; });
    const double most = kAlike * least->cost;
    std::erase_if(ends, [&](const GreyBoxSearch::End& end) { return !(end.cost <= most); });
  }
  follow(search, rows_together > 1 && options.most_mse ? kBoxStepsOfTrial : kMostBoxSteps);
  std::optional<GreyBoxSearch::End> best;
  for (GreyBoxSearch::End& end : ends) {
    work.evaluations += end.evaluations;
    if (std::isfinite(end.cost) && !end.is_hopeless && (!best || end.cost < best->cost)) best = std::move(end);
  }
  if (!best && options.most_mse) {
    throw DataError(fmt::format("model {}: no model of this structure comes below the mean square error {:.3g}",
                                asked.name, *options.most_mse));
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
  model.estimation->input_range = input_range(record, prepared.rows);
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
