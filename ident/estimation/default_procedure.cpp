// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/default_procedure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/error.hpp"
#include "ident/estimation/fit_choice.hpp"
#include "ident/estimation/output_error.hpp"
#include "ident/estimation/rest_before_step.hpp"
#include "ident/estimation/valve_starts.hpp"
#include "ident/estimation/variants.hpp"
#include "ident/search/follow_down.hpp"
#include "ident/search/global_search.hpp"
#include "ident/search/least_squares.hpp"
#include "ident/search/parametrisation.hpp"
#include "ident/search/realisation.hpp"
#include "ident/signal/decimation.hpp"
#include "ident/structure/parameter_requests.hpp"
#include "ident/uncertainty/covariance.hpp"
#include "ident/validation/fit_report.hpp"

namespace eha::ident {
namespace {

// Optima of the coarse record are followed on the whole one while the evidence against them is not strong.
constexpr std::size_t kMostFollowed = 4;
constexpr std::size_t kMostBehindValve = 3;  // optima behind a map that are followed on the whole record
constexpr double kNowhereNear = 4.0;         // times the least cost of a start
// What the search's simulations may be wrong by, relative to the response: far below what tells optima apart.
constexpr double kSearchGuard = 1.6;
constexpr double kSearchResolved = 1e-7;

/// A record made ready for the search, and the poles guessed from it.
struct SearchRecord {
  ComparedRecord compared;
  std::vector<PoleGuess> guesses;
};

/// Which rows are compared, and how many of them estimate.
struct Rows {
  std::size_t discarded = 0;
  Comparison comparison;
  std::size_t estimating = 0;
  std::size_t last = 0;  ///< last row of the record that estimates
};

Rows rows_of(const Record& record, const FitOptions& options) {
  Rows rows;
  rows.discarded = discarded_rows(options.discard_s, record.step_s);
  rows.comparison = compare_every(static_cast<std::size_t>(record.input.size()),
                                  static_cast<std::size_t>(options.decimation), rows.discarded);
  rows.estimating = static_cast<std::size_t>(std::lround(options.split * static_cast<double>(rows.comparison.count)));
  if (rows.estimating < static_cast<std::size_t>(kFewestRows)) {
    throw DataError(fmt::format(
        "record: {} rows are left to estimate from after discarding {} s and keeping every {}th of {} rows (the "
        "anti-alias filter needs {} rows at either end); expected at least {}",
        rows.estimating, options.discard_s, options.decimation, record.input.size(), rows.comparison.taps.size() / 2,
        kFewestRows));
  }
  rows.last = rows.comparison.first + (rows.estimating - 1) * rows.comparison.every;
  return rows;
}

/// The level at which the plant is at rest before the record: as given, or of a step test that shows it, unless an
/// initial state is asked for.
std::optional<double> rest_level(const Record& record, const StructureOptions& asked, const FitOptions& options,
                                 const Rows& rows) {
  if (options.input_before) return options.input_before;
  if (asked.initial_state == InitialState::estimated) return std::nullopt;
  const auto seen = static_cast<Eigen::Index>(rows.last) + 1;
  return rest_of_step_test(record.input.head(seen), record.output.head(seen));
}

/// One structure on one record.
class DefaultFit {
 public:
  DefaultFit(const Record& record, const StructureOptions& asked, const FitOptions& options, const Executor& executor)
      : record_(record),
        options_(options),
        executor_(executor),
        rows_(rows_of(record, options)),
        rest_(rest_level(record, asked, options, rows_)),
        bias_asked_(find_request(asked, asked.structure.input_map.bias) != nullptr),
        behind_valve_(asked_behind_valve(asked)),
        asked_(with_bias_at_rest(without_valve(asked))),
        past_(wants_past_input(asked_)),
        compared_(record, rows_.comparison, rows_.estimating, {.past = past_}),
        coarse_(coarse_records()),
        scale_{record.step_s * static_cast<double>(rows_.last + 1), finest_step_s(), seen_input().minCoeff(),
               seen_input().maxCoeff()},
        parametrisation_(Parametrisation::search(asked_, scale_)) {}

  FitResult run() {
    std::vector<LocalOptimum> optima;
    for (const Variant& variant : variants(asked_, compared_.past().size(), rest_.has_value())) {
      for (LocalOptimum& optimum : estimate(variant, optima)) optima.push_back(std::move(optimum));
    }
    if (optima.empty()) {
      throw NoStableModel(
          fmt::format("model {}: no stable model of this structure was found for the record", asked_.name));
    }
    if (behind_valve_) optima = followed_behind_valve(optima);
    LocalOptimum chosen = choose(optima, scale_.duration_s);
    if (chosen.variant.linear.first_state < 0 && looks_integrating(chosen, scale_.duration_s)) {
      chosen = with_bias_named(chosen);
    }
    chosen = followed_to_its_end(std::move(chosen));
    if (const auto map = valve_of(chosen)) {
      const auto discarded = static_cast<Eigen::Index>(rows_.discarded);
      require_both_sides(*map, seen_input().tail(seen_input().size() - discarded), asked_.name,
                         record_.input_channel.unit);
    }
    return report(chosen);
  }

 private:
  /// Up to the last row that estimates.
  [[nodiscard]] Eigen::Ref<const Eigen::VectorXd> seen_input() const {
    return record_.input.head(static_cast<Eigen::Index>(rows_.last) + 1);
  }
  [[nodiscard]] double largest_input() const { return record_.input.cwiseAbs().maxCoeff(); }

  [[nodiscard]] StructureOptions with_bias_at_rest(const StructureOptions& asked) const {
    StructureOptions held = asked;
    if (rest_ && !bias_asked_) {
      held.parameters.push_back({asked.structure.input_map.bias.key.name, true, 0.0 - *rest_, {}, {}});
    }
    return held;
  }

  [[nodiscard]] std::vector<SearchRecord> coarse_records() const {
    std::vector<SearchRecord> all;
    for (const CoarseRecord& shortened : coarsen(record_, rows_.discarded, rows_.last)) {
      const auto length = static_cast<std::size_t>(shortened.record.input.size());
      std::vector<PoleGuess> guesses;
      if (has_finite_state(asked_.structure)) {
        guesses = guess_poles(shortened.record, length, static_cast<int>(state_count(asked_.structure)),
                              asked_.structure.delay.freedom == Freedom::free);
      }
      ComparedRecord::Options options{past_, kSearchGuard, kSearchResolved};
      if (behind_valve_) {
        options.fine_input = shortened.fine_input;
        options.block = shortened.block;
      }
      all.push_back(
          {ComparedRecord(shortened.record, compare_every(length, 1, shortened.first), shortened.rows, options),
           std::move(guesses)});
    }
    return all;
  }

  /// The search need not resolve more than the coarse records do.
  [[nodiscard]] double finest_step_s() const {
    double finest_s = record_.step_s * static_cast<double>(rows_.last + 1);
    for (const SearchRecord& coarse : coarse_) finest_s = std::min(finest_s, coarse.compared.response().step_s());
    return finest_s;
  }

  /// Coordinates worth a start on a coarse record: guessed poles, and the optima of other variants.
  [[nodiscard]] static std::vector<Eigen::VectorXd> guesses_for(const Parametrisation& parametrisation,
                                                                const SearchRecord& record,
                                                                const std::vector<LocalOptimum>& known) {
    std::vector<Eigen::VectorXd> guesses;
    for (const PoleGuess& guess : record.guesses) {
      if (const auto theta = parametrisation.at_poles(guess.poles, guess.delay_s)) guesses.push_back(*theta);
    }
    for (const LocalOptimum& optimum : known) {
      // The input bias, the last coordinate, may be one of this variant alone.
      const auto shared = static_cast<Eigen::Index>(parametrisation.coordinates().size());
      if (optimum.best.theta.size() >= shared) guesses.push_back(optimum.best.theta.head(shared));
    }
    return guesses;
  }

  /// Optima of one coarse record that are worth following on the whole one.
  std::vector<Eigen::VectorXd> coarse_optima(const OutputError& problem, const SearchRecord& record,
                                             const std::vector<LocalOptimum>& known) {
    const Parametrisation& parametrisation = problem.parametrisation();
    if (options_.search == Search::local) {
      const LeastSquaresResult found = minimise_from_afar(problem, parametrisation.start());
      evaluations_ += found.evaluations;
      return {found.theta};
    }
    const std::size_t free = free_parameters(parametrisation, problem.linear());
    const SearchResult found = search(problem, guesses_for(parametrisation, record, known), options_.seed, executor_);
    evaluations_ += found.evaluations;
    std::vector<Eigen::VectorXd> starts;
    std::size_t followed = 0;
    for (const LeastSquaresResult& optimum : found.optima) {
      const OutputError::Point& best = found.optima.front().point;
      const double effective = residual_model(best.residual).effective_samples;
      const double evidence = effective_bic(optimum.point.cost, best.residual.size(), free, effective) -
                              effective_bic(best.cost, best.residual.size(), free, effective);
      // A thinly covered search box gives every optimum a chance.
      const bool good = followed++ < kMostFollowed && evidence < kStrongEvidence;
      if (good || is_thinly_covered(parametrisation)) starts.push_back(optimum.theta);
    }
    return starts;
  }

  /// Drops starts that are nowhere near on the whole record: one coarse record could not see what they miss.
  [[nodiscard]] std::vector<Eigen::VectorXd> near_on_the_whole(const OutputError& problem,
                                                               const std::vector<Eigen::VectorXd>& starts) {
    std::vector<double> costs(starts.size(), std::numeric_limits<double>::infinity());
    executor_(starts.size(), [&](std::size_t k) {
      if (const auto point = problem.evaluate(starts[k], OutputError::Want::value)) costs[k] = point->cost;
    });
    evaluations_ += starts.size();
    const double least = costs.empty() ? 0.0 : *std::min_element(costs.begin(), costs.end());
    std::vector<Eigen::VectorXd> near;
    for (std::size_t k = 0; k < starts.size(); ++k) {
      if (costs[k] <= kNowhereNear * least) near.push_back(starts[k]);
    }
    return near;
  }

  /// Searches one variant on the coarse records and follows its best optima on the whole one.
  /// @param known  optima of other variants, worth a start in this one
  std::vector<LocalOptimum> estimate(const Variant& variant, const std::vector<LocalOptimum>& known) {
    Parametrisation parametrisation = parametrisation_;
    if (variant.bias_coordinate) parametrisation.add_input_bias(asked_, largest_input(), record_.input[0]);
    std::vector<Eigen::VectorXd> starts;
    for (const SearchRecord& record : coarse_) {
      const OutputError problem(record.compared, parametrisation, variant.linear);
      for (Eigen::VectorXd& theta : coarse_optima(problem, record, known)) starts.push_back(std::move(theta));
    }
    const OutputError problem(compared_, parametrisation, variant.linear);
    // So does the start that was asked for.
    if (is_thinly_covered(parametrisation)) starts.push_back(parametrisation.start());
    if (coarse_.size() > 1) starts = near_on_the_whole(problem, starts);
    return followed(problem, variant, starts);
  }

  /// Optima on the whole record.
  std::vector<LocalOptimum> followed(const OutputError& problem, const Variant& variant,
                                     const std::vector<Eigen::VectorXd>& starts) {
    const Parametrisation& parametrisation = problem.parametrisation();
    std::vector<LeastSquaresResult> refined(starts.size());
    executor_(starts.size(), [&](std::size_t k) { refined[k] = minimise(problem, starts[k]); });
    // Valleys are flat where many coefficients are estimated.
    if (is_thinly_covered(parametrisation)) follow_down_all(problem, refined);
    std::vector<LocalOptimum> optima;
    const std::size_t free = free_parameters(parametrisation, variant.linear);
    for (LeastSquaresResult& r : refined) {
      evaluations_ += r.evaluations;
      if (r.termination != Termination::infeasible) optima.push_back({variant, parametrisation, std::move(r), free});
    }
    return optima;
  }

  /// Turns to the structure behind its map. @param linear  optima without the map
  std::vector<LocalOptimum> followed_behind_valve(const std::vector<LocalOptimum>& linear) {
    asked_ = *behind_valve_;
    parametrisation_ = Parametrisation::search(asked_, scale_);
    std::vector<LocalOptimum> optima;
    for (const Variant& variant : variants(asked_, compared_.past().size(), rest_.has_value())) {
      const OutputError coarse(coarse_.front().compared, parametrisation_, variant.linear);
      const SearchResult found =
          polished(coarse, valve_starts(linear, variant, parametrisation_, asked_, scale_), executor_);
      evaluations_ += found.evaluations;
      std::vector<Eigen::VectorXd> starts;
      for (std::size_t k = 0; k < std::min(found.optima.size(), kMostBehindValve); ++k) {
        starts.push_back(found.optima[k].theta);
      }
      const OutputError problem(compared_, parametrisation_, variant.linear);
      for (LocalOptimum& optimum : followed(problem, variant, starts)) optima.push_back(std::move(optimum));
    }
    return optima;
  }

  /// Near an integrator, replaces the free-response terms by the equivalent input bias and output offset, whose values
  /// stay in the record's range: the first term is what an input bias does, the last state what the offset does.
  LocalOptimum with_bias_named(const LocalOptimum& moving) {
    LocalOptimum named{variant_at_rest(asked_), moving.parametrisation, {}, 0};
    named.variant.linear.initial_states = static_cast<int>(state_count(asked_.structure)) - 1;
    Eigen::VectorXd start = moving.best.theta;
    if (named.variant.bias_coordinate) {
      named.parametrisation.add_input_bias(asked_, largest_input(), record_.input[0]);
      start.conservativeResize(start.size() + 1);
      start[start.size() - 1] = equivalent_bias(moving);
    }
    if (behind_valve_) move_null(named.parametrisation, start, -equivalent_bias(moving));
    named.free = free_parameters(named.parametrisation, named.variant.linear);
    named.best = minimise(OutputError(compared_, named.parametrisation, named.variant.linear), start);
    evaluations_ += named.best.evaluations;
    return named.best.termination == Termination::infeasible ? moving : named;
  }

  /// Goes on from the chosen optimum where its search used up its evaluations, as it does along a flat valley.
  LocalOptimum followed_to_its_end(LocalOptimum chosen) {
    if (chosen.best.termination != Termination::evaluation_limit) return chosen;
    const OutputError problem(compared_, chosen.parametrisation, chosen.variant.linear);
    const std::size_t before = chosen.best.evaluations;
    chosen.best = followed_down(problem, std::move(chosen.best), 1);
    evaluations_ += chosen.best.evaluations - before;
    return chosen;
  }

  /// Writes the linear quantities into the model.
  void fill_linear(Model& model, const LinearPart& reported, const LinearSolution& solution) const {
    model.input_bias = solution.input_bias;
    model.initial_output = solution.initial_output;
    if (!past_) {
      model.initial_state.assign(solution.initial_state.begin(), solution.initial_state.end());
      return;
    }
    const std::vector<PastInput>& windows = compared_.past_windows();
    const std::size_t shared = reported.past_shared;
    for (std::size_t k = 0; k < windows.size(); k += shared) {
      const std::size_t oldest = std::min(k + shared, windows.size()) - 1;
      model.past_input.push_back(
          {windows[oldest].from_s, windows[k].to_s, solution.initial_state[static_cast<Eigen::Index>(k / shared)]});
    }
  }

  void fill_provenance(Model& model, const LinearPart& reported) const {
    const Structure& structure = asked_.structure;
    const std::size_t scale = normalised_index(structure.denominator.size());
    const StructureParameter& lowest = structure.denominator.front().order;
    const bool lowest_is_0 = structure.base_order || (lowest.freedom == Freedom::constant && lowest.value <= 0.0);
    model.provenance["normalisation"] = structure.denominator[scale].coefficient.key.name + " = 1" +
                                        (lowest_is_0 ? ", lowest order of the denominator 0" : "");
    if (behind_valve_) return;
    if (rest_ && !bias_asked_) {
      model.provenance["input_bias"] = options_.input_before ? "fixed: at rest at the input given for before the record"
                                                             : "fixed: a step test that starts at rest at that level";
    } else if (!bias_asked_ && !reported.solve_bias && reported.fixed_bias == 0.0) {
      model.provenance["input_bias"] =
          "fixed at 0: with an initial state a constant input cannot be told apart from offset and state";
    }
  }

  [[nodiscard]] FitResult report(const LocalOptimum& chosen) const {
    LinearSolution solution = chosen.best.point.linear;
    const Normalised scaled =
        normalised(chosen.parametrisation.transfer_function(chosen.best.theta, solution.numerator));
    for (Eigen::Index j = 0; j < solution.numerator.size(); ++j) {
      solution.numerator[j] = scaled.g.numerator[static_cast<std::size_t>(j)].coefficient;
    }
    if (!past_) solution.initial_state /= scaled.divisor;
    const LinearPart reported = as_reported(chosen, scaled.g, solution);
    const Termination end = chosen.best.termination;
    FitResult result = begin_report(record_, asked_.name, "default", scaled.g,
                                    {.evaluations = evaluations_,
                                     .termination = std::string(text(end)),
                                     .converged = end == Termination::converged || end == Termination::at_bound});
    Model& model = result.model;
    model.input_map = valve_of(chosen);
    fill_linear(model, reported, solution);
    fill_provenance(model, reported);
    result.estimation_samples = rows_.estimating;
    const ProfileSearch profile{scale_, largest_input(), executor_};
    fill_parameters(
        result, {.compared = compared_, .optimum = chosen, .linear = reported, .solution = solution, .asked = asked_},
        options_.intervals == IntervalMethod::profile ? &profile : nullptr);
    const double compared_step_s = record_.step_s * static_cast<double>(rows_.comparison.every);
    model.bode = bode_curve(model, bode_frequencies(scale_.duration_s, compared_step_s), result.covariance);
    fill_validation(result, record_, rows_.comparison);
    // Highest order first, as transfer functions are written.
    std::reverse(model.transfer_function.numerator.begin(), model.transfer_function.numerator.end());
    std::reverse(model.transfer_function.denominator.begin(), model.transfer_function.denominator.end());
    return result;
  }

  const Record& record_;
  const FitOptions& options_;
  const Executor& executor_;
  Rows rows_;
  std::optional<double> rest_;  ///< level before a step test [input unit]
  bool bias_asked_;
  std::optional<StructureOptions> behind_valve_;  ///< what is asked, where its structure has a valve map
  StructureOptions asked_;                        ///< without the map until followed_behind_valve()
  bool past_;
  ComparedRecord compared_;
  std::vector<SearchRecord> coarse_;
  Parametrisation::Scale scale_;  ///< the estimating part sets it
  Parametrisation parametrisation_;
  std::size_t evaluations_ = 0;
};

}  // namespace

FitResult fit_by_default(const Record& record, const StructureOptions& asked, const FitOptions& options,
                         const Executor& executor) {
  return DefaultFit(record, asked, options, executor).run();
}

}  // namespace eha::ident
