// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/error.hpp"
#include "ident/estimation/fit_choice.hpp"
#include "ident/estimation/fit_report.hpp"
#include "ident/estimation/global_search.hpp"
#include "ident/estimation/least_squares.hpp"
#include "ident/estimation/output_error.hpp"
#include "ident/estimation/paper_procedure.hpp"
#include "ident/estimation/parametrisation.hpp"
#include "ident/estimation/realisation.hpp"
#include "ident/estimation/rest_before_step.hpp"
#include "ident/estimation/uncertainty.hpp"
#include "ident/fractional/stability.hpp"

namespace eha::ident {
namespace {

constexpr Eigen::Index kFewestRows = 20;
// Optima of the coarse record are followed on the whole one while the evidence against them is not strong.
constexpr std::size_t kMostFollowed = 4;
constexpr double kNowhereNear = 4.0;  // times the least cost of a start
// What the search's simulations may be wrong by, relative to the response: far below what tells optima apart.
constexpr double kSearchGuard = 1.6;
constexpr double kSearchResolved = 1e-7;

LinearQuantity quantity(const StructureOptions& structure, const std::string& name) {
  LinearQuantity q;
  if (const ParameterRequest* request = find_request(structure, name)) {
    q.fixed = request->fixed.value_or(false);
    q.value = request->start.value_or(0.0);
    q.lower = request->lower.value_or(q.lower);
    q.upper = request->upper.value_or(q.upper);
  }
  return q;
}

Variant variant_at_rest(const StructureOptions& structure, std::size_t numerator_terms) {
  Variant at_rest;
  for (std::size_t j = 0; j < numerator_terms; ++j) {
    at_rest.linear.numerator.push_back(quantity(structure, numerator_name(j, numerator_terms)));
  }
  at_rest.linear.initial_output = quantity(structure, "initial_output");
  const ParameterRequest* bias = find_request(structure, "input_bias");
  const bool bias_fixed = bias != nullptr && bias->fixed.value_or(false);
  if (bias_fixed) at_rest.linear.fixed_bias = bias->start.value_or(0.0);
  // With one numerator term the bias enters linearly, beside the gain; bounds on it make it a coordinate.
  const bool bounded = bias != nullptr && (bias->lower || bias->upper);
  at_rest.linear.solve_bias = !bias_fixed && !bounded && numerator_terms == 1;
  at_rest.bias_coordinate = !bias_fixed && !at_rest.linear.solve_bias;
  return at_rest;
}

/// @param windows  of the past in the record, when the structure wants a past input
/// @param at_rest_before  whether the record is known to begin at rest
std::vector<Variant> variants(const StructureOptions& structure, std::size_t numerator_terms, std::size_t windows,
                              bool at_rest_before) {
  const Variant at_rest = variant_at_rest(structure, numerator_terms);
  if (wants_past_input(structure)) {
    // How finely the past can be told is for the data to say.
    std::vector<Variant> excited;
    for (const std::size_t shared : {4, 2, 1}) {
      excited.push_back(at_rest);
      excited.back().linear.past_shared = shared;
      excited.back().linear.initial_states = static_cast<int>((windows + shared - 1) / shared);
    }
    return excited;
  }
  if (structure.kind != StructureKind::io || structure.initial_state == InitialState::none) return {at_rest};
  // A constant input switched on at t = 0 is, for integer orders, one of the free responses.
  Variant moving = at_rest;
  moving.linear.solve_bias = false;
  moving.bias_coordinate = false;
  moving.linear.initial_states = structure.poles;
  const ParameterRequest* offset = find_request(structure, "initial_output");
  if (offset != nullptr && offset->fixed.value_or(false)) {
    // Nothing else does the bias's work then.
    moving.linear.solve_bias = at_rest.linear.solve_bias;
    moving.bias_coordinate = at_rest.bias_coordinate;
  } else if (offset == nullptr) {
    // The constant is one of the free responses when 1/D's step response is: see LinearPart::first_state.
    moving.linear.initial_output.fixed = true;
    moving.linear.initial_states = structure.poles + 1;
    moving.linear.first_state = -1;
  }
  if (structure.initial_state == InitialState::estimated) return {moving};
  if (at_rest_before) return {at_rest};
  return {at_rest, moving};
}

std::size_t free_parameters(const Parametrisation& parametrisation, const LinearPart& linear) {
  std::size_t free = parametrisation.coordinates().size() + static_cast<std::size_t>(linear.initial_states);
  for (const LinearQuantity& q : linear.numerator) free += q.fixed ? 0 : 1;
  return free + (linear.solve_bias ? 1 : 0) + (linear.initial_output.fixed ? 0 : 1);
}

void check_record(const Record& record, const FitOptions& options) {
  if (record.input.size() != record.output.size()) throw DataError("record: input and output differ in length");
  if (!record.input.allFinite() || !record.output.allFinite()) throw DataError("record: expected finite samples");
  if (!(record.step_s > 0.0)) throw DataError("record: expected a positive sample period");
  if (options.decimation < 1)
    throw ConfigError(fmt::format("decimation: expected at least 1, got {}", options.decimation));
  if (!(options.split > 0.0) || options.split > 1.0) {
    throw ConfigError(fmt::format("split: expected a share above 0 and up to 1, got {}", options.split));
  }
  if (record.input.size() < kFewestRows) {
    throw DataError(
        fmt::format("record: {} rows are too few to fit; expected at least {}", record.input.size(), kFewestRows));
  }
  const auto constant = [](const Eigen::VectorXd& v) { return (v.array() == v[0]).all(); };
  if (constant(record.input)) {
    throw DataError(
        fmt::format("record: the input is constant at {} {}; a model needs an input that moves (a step at "
                    "the start needs rows from before it)",
                    record.input[0], record.input_channel.unit));
  }
  if (constant(record.output)) {
    throw DataError(fmt::format("record: the output is constant at {} {}; a model needs an output that moves",
                                record.output[0], record.output_channel.unit));
  }
}

/// A record made ready for the search, and what it says without one.
struct SearchRecord {
  ComparedRecord compared;
  std::vector<PoleGuess> guesses;
};

/// Searches one variant on the coarse records and follows its best optima on the whole one.
/// @param known  optima of another variant, worth a start in this one
std::vector<Outcome> estimate(const Parametrisation& parametrisation, const Variant& variant,
                              const ComparedRecord& compared, const std::vector<SearchRecord>& coarse,
                              const std::vector<Outcome>& known, const FitOptions& options, const Executor& executor,
                              std::size_t& evaluations) {
  const std::size_t free = free_parameters(parametrisation, variant.linear);
  std::vector<Eigen::VectorXd> starts;
  for (const SearchRecord& record : coarse) {
    const OutputError problem(record.compared, parametrisation, variant.linear);
    if (options.search == Search::local) {
      const LeastSquaresResult found = minimise_from_afar(problem, parametrisation.start());
      evaluations += found.evaluations;
      starts.push_back(found.theta);
      continue;
    }
    std::vector<Eigen::VectorXd> guesses;
    for (const PoleGuess& guess : record.guesses) {
      if (const auto theta = parametrisation.at_poles(guess.poles, guess.delay_s)) guesses.push_back(*theta);
    }
    for (const Outcome& o : known) {
      // The input bias, the last coordinate, may be one of this variant alone.
      const auto shared = static_cast<Eigen::Index>(parametrisation.coordinates().size());
      if (o.best.theta.size() >= shared) guesses.push_back(o.best.theta.head(shared));
    }
    const SearchResult found = search(problem, guesses, options.seed, executor);
    evaluations += found.evaluations;
    std::size_t followed = 0;
    for (const LeastSquaresResult& optimum : found.optima) {
      const OutputError::Point& best = found.optima.front().point;
      const double effective = residual_model(best.residual).effective_samples;
      const double evidence = effective_bic(optimum.point.cost, best.residual.size(), free, effective) -
                              effective_bic(best.cost, best.residual.size(), free, effective);
      if (followed++ < kMostFollowed && evidence < kStrongEvidence) starts.push_back(optimum.theta);
    }
  }
  const OutputError problem(compared, parametrisation, variant.linear);
  if (coarse.size() > 1) {
    // What one coarse record could not see may be nowhere near on the whole one.
    std::vector<double> costs(starts.size(), std::numeric_limits<double>::infinity());
    executor(starts.size(), [&](std::size_t k) {
      if (const auto point = problem.evaluate(starts[k], OutputError::Want::value)) costs[k] = point->cost;
    });
    evaluations += starts.size();
    const double least = costs.empty() ? 0.0 : *std::min_element(costs.begin(), costs.end());
    std::vector<Eigen::VectorXd> near;
    for (std::size_t k = 0; k < starts.size(); ++k) {
      if (costs[k] <= kNowhereNear * least) near.push_back(starts[k]);
    }
    starts = std::move(near);
  }
  std::vector<LeastSquaresResult> refined(starts.size());
  executor(starts.size(), [&](std::size_t k) { refined[k] = minimise(problem, starts[k]); });
  std::vector<Outcome> outcomes;
  for (LeastSquaresResult& r : refined) {
    evaluations += r.evaluations;
    if (r.termination != Termination::infeasible) outcomes.push_back({variant, parametrisation, std::move(r), free});
  }
  return outcomes;
}

/// A moving model near an integrator said in terms that stay within the record: the first free response, whose other
/// name is an offset far outside it, is what an input bias does, and the last state what the offset does.
Outcome with_bias_named(const Outcome& moving, const StructureOptions& structure, const ComparedRecord& compared,
                        const Record& record, std::size_t& evaluations) {
  const LinearSolution& found = moving.best.point.linear;
  const TransferFunction g = moving.parametrisation.transfer_function(moving.best.theta, found.numerator);
  const Eigen::VectorXd& c = found.initial_state;
  Outcome named{variant_at_rest(structure, moving.parametrisation.numerator_terms()), moving.parametrisation, {}, 0};
  named.variant.linear.initial_states = structure.poles - 1;
  Eigen::VectorXd start = moving.best.theta;
  if (named.variant.bias_coordinate) {
    named.parametrisation.add_input_bias(structure, record.input.cwiseAbs().maxCoeff(), record.input[0]);
    start.conservativeResize(start.size() + 1);
    const double offset = c[c.size() - 1] / g.denominator.back().coefficient;
    const double pushed = c[0] - offset * g.denominator.front().coefficient;
    start[start.size() - 1] = found.numerator[0] == 0.0 ? 0.0 : pushed / found.numerator[0];
  }
  named.free = free_parameters(named.parametrisation, named.variant.linear);
  named.best = minimise(OutputError(compared, named.parametrisation, named.variant.linear), start);
  evaluations += named.best.evaluations;
  return named.best.termination == Termination::infeasible ? moving : named;
}

// Of max |u|. A record that starts at rest at its largest input has a bias of that size.
constexpr double kGreatestBias = 3.0;

/// Whether the compared samples say nothing about the input bias: not even that it is smaller than the input. So it is
/// for a plant of finite DC gain whose start from rest is not compared; the offset then does the bias's work.
bool is_bias_lost(const Model& model, double largest_input) {
  const auto bias = std::find_if(model.parameters.begin(), model.parameters.end(),
                                 [](const ParameterEstimate& p) { return p.name == "input_bias"; });
  return bias != model.parameters.end() && !bias->fixed &&
         !(std::max(bias->std, std::abs(bias->value) / kGreatestBias) < largest_input);
}

FitResult fit_by_default(const Record& record, const StructureOptions& asked, const FitOptions& options,
                         const Executor& executor) {
  const auto discard = static_cast<std::size_t>(std::ceil(options.discard_s / record.step_s - 1e-9));
  const Comparison comparison = compare_every(static_cast<std::size_t>(record.input.size()),
                                              static_cast<std::size_t>(options.decimation), discard);
  const auto rows = static_cast<std::size_t>(std::lround(options.split * static_cast<double>(comparison.count)));
  if (rows < static_cast<std::size_t>(kFewestRows)) {
    throw DataError(fmt::format(
        "record: {} rows are left to estimate from after discarding {} s and keeping every {}th of {} rows (the "
        "anti-alias filter needs {} rows at either end); expected at least {}",
        rows, options.discard_s, options.decimation, record.input.size(), comparison.taps.size() / 2, kFewestRows));
  }
  const std::size_t last = comparison.first + (rows - 1) * comparison.every;
  StructureOptions structure = asked;
  const auto seen = static_cast<Eigen::Index>(last) + 1;
  const auto rest = structure.initial_state == InitialState::estimated
                        ? std::nullopt
                        : rest_of_step_test(record.input.head(seen), record.output.head(seen));
  const bool is_bias_asked = find_request(structure, "input_bias") != nullptr;
  if (rest && !is_bias_asked) structure.parameters.push_back({"input_bias", true, 0.0 - *rest, {}, {}});
  const bool past = wants_past_input(structure);
  const ComparedRecord compared(record, comparison, rows, {.past = past});
  // The fitted part sets the scale; the search need not resolve more than the coarse records do.
  const double duration_s = record.step_s * static_cast<double>(last + 1);
  double finest_s = duration_s;
  std::vector<SearchRecord> coarse;
  for (const CoarseRecord& shortened : coarsen(record, discard, last)) {
    const auto length = static_cast<std::size_t>(shortened.record.input.size());
    std::vector<PoleGuess> guesses;
    if (structure.kind == StructureKind::io) {
      guesses = guess_poles(shortened.record, length, structure.poles, structure.delay_free);
    }
    coarse.push_back({ComparedRecord(shortened.record, compare_every(length, 1, shortened.first), shortened.rows,
                                     {past, kSearchGuard, kSearchResolved}),
                      std::move(guesses)});
    finest_s = std::min(finest_s, shortened.record.step_s);
  }
  const Parametrisation::Scale scale{duration_s, finest_s};
  const Parametrisation parametrisation = Parametrisation::search(structure, scale);
  std::vector<Outcome> outcomes;
  std::size_t evaluations = 0;
  for (const Variant& variant :
       variants(structure, parametrisation.numerator_terms(), compared.past().size(), rest.has_value())) {
    Parametrisation coordinates = parametrisation;
    if (variant.bias_coordinate) {
      coordinates.add_input_bias(structure, record.input.cwiseAbs().maxCoeff(), record.input[0]);
    }
    for (Outcome& o : estimate(coordinates, variant, compared, coarse, outcomes, options, executor, evaluations)) {
      outcomes.push_back(std::move(o));
    }
  }
  if (outcomes.empty()) {
    throw NoStableModel(
        fmt::format("model {}: no stable model of this structure was found for the record", structure.name));
  }
  Outcome chosen = choose(outcomes, duration_s);
  if (chosen.variant.linear.first_state < 0 && looks_integrating(chosen, duration_s)) {
    chosen = with_bias_named(chosen, structure, compared, record, evaluations);
  }

  FitResult result;
  LinearSolution solution = chosen.best.point.linear;
  const Normalised scaled = normalised(chosen.parametrisation.transfer_function(chosen.best.theta, solution.numerator));
  solution.numerator /= scaled.divisor;
  if (!past) solution.initial_state /= scaled.divisor;
  const LinearPart reported = as_reported(chosen, scaled.g, solution);
  Model& model = result.model;
  model.name = structure.name;
  model.transfer_function = scaled.g;
  model.input_bias = solution.input_bias;
  model.initial_output = solution.initial_output;
  if (past) {
    const std::vector<PastInput>& windows = compared.past_windows();
    const std::size_t shared = reported.past_shared;
    for (std::size_t k = 0; k < windows.size(); k += shared) {
      const std::size_t oldest = std::min(k + shared, windows.size()) - 1;
      model.past_input.push_back(
          {windows[oldest].from_s, windows[k].to_s, solution.initial_state[static_cast<Eigen::Index>(k / shared)]});
    }
  } else {
    model.initial_state.assign(solution.initial_state.begin(), solution.initial_state.end());
  }
  model.input_unit = record.input_channel.unit;
  model.output_unit = record.output_channel.unit;
  model.procedure = "default";
  model.estimation.emplace();
  model.estimation->evaluations = evaluations;
  model.estimation->termination = text(chosen.best.termination);
  model.estimation->converged =
      chosen.best.termination == Termination::converged || chosen.best.termination == Termination::at_bound;
  model.stability = stability(model.transfer_function);
  model.provenance["normalisation"] = "a1 = 1, lowest order of the denominator 0";
  if (rest && !is_bias_asked) {
    model.provenance["input_bias"] = "fixed: a step test that starts at rest at that level";
  } else if (!is_bias_asked && !reported.solve_bias && reported.fixed_bias == 0.0) {
    model.provenance["input_bias"] =
        "fixed at 0: with an initial state a constant input cannot be told apart from offset and state";
  }
  result.estimation_samples = rows;
  const ProfileSearch profile{scale, record.input.cwiseAbs().maxCoeff(), executor};
  fill_parameters(result, compared, chosen, reported, solution, structure,
                  options.intervals == IntervalMethod::profile ? &profile : nullptr);
  model.bode = bode_curve(model, bode_frequencies(duration_s, record.step_s * static_cast<double>(comparison.every)),
                          result.covariance);
  fill_validation(result, record, comparison);
  // Highest order first, as transfer functions are written.
  std::reverse(model.transfer_function.numerator.begin(), model.transfer_function.numerator.end());
  std::reverse(model.transfer_function.denominator.begin(), model.transfer_function.denominator.end());
  return result;
}

}  // namespace

FitResult fit(const Record& record, const StructureOptions& structure, const FitOptions& options,
              const Executor& executor) {
  check_record(record, options);
  if (options.procedure == Procedure::paper) return fit_by_paper(record, structure, options);
  FitResult result = fit_by_default(record, structure, options, executor);
  if (find_request(structure, "input_bias") != nullptr ||
      !is_bias_lost(result.model, record.input.cwiseAbs().maxCoeff())) {
    return result;
  }
  StructureOptions without = structure;
  without.parameters.push_back({"input_bias", true, 0.0, {}, {}});
  result = fit_by_default(record, without, options, executor);
  result.model.provenance["input_bias"] =
      "fixed at 0: in the compared samples a constant input cannot be told apart from the offset";
  return result;
}

ValidationReport validate(const Model& model, const Record& record, const FitOptions& options) {
  check_record(record, options);
  FitResult result;
  result.model = model;
  result.model.past_input.clear();  // it was that of another record
  const auto discard = static_cast<std::size_t>(std::ceil(options.discard_s / record.step_s - 1e-9));
  const Comparison comparison = compare_every(static_cast<std::size_t>(record.input.size()),
                                              static_cast<std::size_t>(options.decimation), discard);
  if (comparison.count < 2) throw DataError("record: too few rows are left to score the model on");
  fill_validation(result, record, comparison);
  return *result.model.validation;
}

}  // namespace eha::ident
