// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/default_procedure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "ident/coordinates/parametrisation.hpp"
#include "ident/estimation/fit_choice.hpp"
#include "ident/estimation/fit_rows.hpp"
#include "ident/estimation/fitted_optimum.hpp"
#include "ident/estimation/known_starts.hpp"
#include "ident/estimation/moving_gain.hpp"
#include "ident/estimation/nearest_fit.hpp"
#include "ident/estimation/noise_fit.hpp"
#include "ident/estimation/optimum_report.hpp"
#include "ident/estimation/valve_starts.hpp"
#include "ident/estimation/variants.hpp"
#include "ident/output_error/output_error.hpp"
#include "ident/search/follow_down.hpp"
#include "ident/search/global_search.hpp"
#include "ident/search/least_squares.hpp"
#include "ident/structure/parameter_requests.hpp"
#include "ident/uncertainty/covariance.hpp"

namespace eha::ident {
namespace {

// Optima of the coarse record are followed on the whole one while the evidence against them is not strong.
constexpr std::size_t kMostFollowed = 4;
constexpr std::size_t kMostFollowedFromKnown = 1;  // beside the best known model
constexpr std::size_t kMostBehindValve = 3;        // optima behind a map that are followed on the whole record
constexpr double kNowhereNear = 4.0;               // times the least cost of a start
constexpr int kMostFurtherRounds = 3;              // along a flat valley

/// One structure on one record.
class DefaultFit {
 public:
  DefaultFit(const PreparedRecord& prepared, const StructureOptions& asked, const FitOptions& options,
             const Executor& executor, const std::vector<Model>& known)
      : prepared_(prepared),
        record_(prepared.record),
        given_(asked),
        options_(options),
        executor_(executor),
        known_(known),
        rows_(prepared.rows),
        rest_(rest_level(record_, asked, options, rows_)),
        bias_asked_(find_request(asked, asked.structure.input_map.bias) != nullptr),
        behind_valve_(asked_behind_valve(asked)),
        asked_(with_bias_at_rest(without_valve(asked))),
        past_(wants_past_input(asked_)),
        compared_(prepared.compared({past_, behind_valve_.has_value()})),
        searched_(prepared.searched({past_, behind_valve_.has_value()})),
        scale_{record_.step_s * static_cast<double>(rows_.last + 1), finest_step_s(), seen_input().minCoeff(),
               seen_input().maxCoeff()},
        parametrisation_(Parametrisation::search(asked_, scale_)) {}

  /// The report of an optimum that this structure had.
  FitResult again(const FittedOptimum& fitted) {
    if (behind_valve_) asked_ = *behind_valve_;
    return report(fitted.optimum);
  }

  FitResult run() {
    if (options_.search == Search::nearest) {
      if (const auto near = nearest()) return report(with_bias_named_if_integrating(*near));
    }
    std::vector<LocalOptimum> optima;
    const bool maps_known_models = behind_valve_ && options_.search == Search::known && has_known_behind_valve();
    for (const Variant& variant : variants(asked_, compared_.past().size(), rest_.has_value())) {
      if (maps_known_models) break;
      if (is_left_out(variant, optima)) continue;
      for (LocalOptimum& optimum : estimate(variant, optima)) optima.push_back(std::move(optimum));
    }
    if (behind_valve_) {
      for (const LocalOptimum& optimum : optima)
        cost_without_map_ = std::min(cost_without_map_, optimum.best.point.cost);
      optima = followed_behind_valve(optima);
    }
    if (optima.empty()) throw_no_stable_model();
    LocalOptimum chosen = no_worse_than_known(optima, choose(optima, scale_.duration_s));
    chosen = with_terms_revived(std::move(chosen));
    chosen = with_bias_named_if_integrating(chosen);
    chosen = followed_to_its_end(std::move(chosen));
    if (auto refined = with_noise_model(compared_, chosen, most_cost_inside(chosen), work_["noise"])) {
      chosen = std::move(*refined);
    }
    check_map(chosen);
    return report(chosen);
  }

 private:
  /// Roughly, from the known model of least error that is one of the structure; nothing without one.
  std::optional<LocalOptimum> nearest() {
    const StructureOptions& asked = behind_valve_ ? *behind_valve_ : asked_;
    const NearestFit fit{compared_, asked, scale_, largest_input(), record_.input[0], rest_.has_value()};
    auto optimum = nearest_optimum(fit, known_, work_["search"]);
    if (!optimum) return {};
    if (behind_valve_) asked_ = *behind_valve_;
    check_map(*optimum);
    return optimum;
  }

  void check_map(const LocalOptimum& chosen) const {
    if (const auto map = valve_of(chosen)) {
      const auto discarded = static_cast<Eigen::Index>(rows_.discarded);
      require_both_sides(*map, seen_input().tail(seen_input().size() - discarded), asked_.name,
                         record_.input_channel.unit);
    }
  }

  [[noreturn]] void throw_no_stable_model() const {
    throw NoStableModel(
        fmt::format("model {}: no stable model of this structure was found for the record", asked_.name));
  }

  [[nodiscard]] bool has_known_behind_valve() const {
    return !known_starts(Parametrisation::search(*behind_valve_, scale_), known_, scale_).at.empty();
  }

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

  /// The search need not resolve more than what it simulates.
  [[nodiscard]] double finest_step_s() const {
    double finest_s = record_.step_s * static_cast<double>(rows_.last + 1);
    for (const ComparedRecord* searched : searched_) finest_s = std::min(finest_s, searched->response().spacing_s());
    return finest_s;
  }

  /// Whether searches from afar simulate the compared rows themselves.
  [[nodiscard]] bool searches_whole() const { return searched_.size() == 1 && searched_.front() == &compared_; }

  [[nodiscard]] const std::vector<PoleGuess>& pole_guesses() {
    if (!guesses_) {
      const Structure& structure = asked_.structure;
      guesses_.emplace();
      if (has_finite_state(structure)) {
        guesses_ =
            prepared_.guesses(static_cast<int>(state_count(structure)), structure.delay.freedom == Freedom::free);
      }
    }
    return *guesses_;
  }

  /// A guess of poles says nothing of the input's bias, which the closest known model has.
  [[nodiscard]] static Eigen::VectorXd with_bias_of(const KnownStarts& known, const Parametrisation& parametrisation,
                                                    Eigen::VectorXd guess) {
    const std::vector<Coordinate>& coordinates = parametrisation.coordinates();
    for (std::size_t l = 0; l < coordinates.size() && !known.at.empty(); ++l) {
      const auto i = static_cast<Eigen::Index>(l);
      if (coordinates[l].role == CoordinateRole::input_bias) guess[i] = known.at.front()[i];
    }
    return guess;
  }

  /// Coordinates worth a start: guessed poles, known models, and the optima of other variants.
  [[nodiscard]] std::vector<Eigen::VectorXd> guesses_for(const Parametrisation& parametrisation,
                                                         const std::vector<LocalOptimum>& found) {
    std::vector<Eigen::VectorXd> guesses;
    const KnownStarts known = known_starts(parametrisation, known_, scale_);
    for (const PoleGuess& guess : pole_guesses()) {
      const auto theta = parametrisation.at_poles(guess.poles, guess.delay_s);
      if (theta) guesses.push_back(with_bias_of(known, parametrisation, *theta));
    }
    known.append_to(guesses);
    for (const LocalOptimum& optimum : found) {
      // The input bias, the last coordinate, may be one of this variant alone.
      const auto shared = static_cast<Eigen::Index>(parametrisation.coordinates().size());
      if (optimum.best.theta.size() >= shared) guesses.push_back(optimum.best.theta.head(shared));
    }
    return guesses;
  }

  /// Rough optima of one searched record that are worth following on the whole one.
  /// @param known  optima of other variants, worth a start in this one
  std::vector<LeastSquaresResult> rough_optima(const OutputError& problem, const std::vector<LocalOptimum>& known) {
    const Parametrisation& parametrisation = problem.parametrisation();
    if (options_.search == Search::local) {
      LeastSquaresResult found = minimise_from_afar(problem, parametrisation.start());
      work_["search"] += found.work;
      return {std::move(found)};
    }
    const std::size_t free = free_parameters(parametrisation, problem.linear());
    const std::vector<Eigen::VectorXd> guesses = guesses_for(parametrisation, known);
    SearchResult found;
    if (options_.search == Search::known) found = polished(problem, guesses, Wanted::best, executor_);
    if (found.optima.empty()) {
      work_["search"] += found.work;
      found = search(problem, guesses, options_.seed, executor_);
    }
    work_["search"] += found.work;
    std::vector<LeastSquaresResult> worth;
    std::size_t followed = 0;
    if (found.optima.empty()) return worth;
    const OutputError::Point best = found.optima.front().point;
    const double effective = residual_model(best.residual).effective_samples;
    for (LeastSquaresResult& optimum : found.optima) {
      const double evidence = effective_bic(optimum.point.cost, best.residual.size(), free, effective) -
                              effective_bic(best.cost, best.residual.size(), free, effective);
      // If the search box is covered sparsely, every optimum is followed.
      const std::size_t most = options_.search == Search::known ? kMostFollowedFromKnown : kMostFollowed;
      const bool good = followed++ < most && evidence < kStrongEvidence;
      if (good || is_thinly_covered(parametrisation)) worth.push_back(std::move(optimum));
    }
    return worth;
  }

  /// The starts on the whole record.
  std::vector<LeastSquaresResult> begun_at(const OutputError& problem, const std::vector<Eigen::VectorXd>& starts) {
    std::vector<LeastSquaresResult> searches(starts.size());
    executor_(starts.size(), [&](std::size_t k) { searches[k] = begun(problem, starts[k]); });
    return searches;
  }

  /// Drops starts with a far higher cost on the whole record, which the searched one did not show.
  static void drop_distant(std::vector<LeastSquaresResult>& searches) {
    double least = std::numeric_limits<double>::infinity();
    for (const LeastSquaresResult& s : searches) {
      if (s.termination != Termination::infeasible) least = std::min(least, s.point.cost);
    }
    std::erase_if(searches, [&](const LeastSquaresResult& s) {
      return s.termination == Termination::infeasible || !(s.point.cost <= kNowhereNear * least);
    });
  }

  /// Searches one variant from afar and follows its best optima on the whole record.
  /// @param known  optima of other variants, worth a start in this one
  std::vector<LocalOptimum> estimate(const Variant& variant, const std::vector<LocalOptimum>& known) {
    Parametrisation parametrisation = parametrisation_;
    if (variant.bias_coordinate) parametrisation.add_input_bias(asked_, largest_input(), record_.input[0]);
    const OutputError problem(compared_, parametrisation, variant.linear);
    std::vector<LeastSquaresResult> searches;
    std::vector<Eigen::VectorXd> starts;
    if (searches_whole()) {
      searches = rough_optima(problem, known);
      forget_work(searches);
    } else {
      for (const ComparedRecord* searched : searched_) {
        const OutputError rough(*searched, parametrisation, variant.linear);
        for (LeastSquaresResult& optimum : rough_optima(rough, known)) starts.push_back(std::move(optimum.theta));
      }
    }
    // The requested start is followed too.
    if (is_thinly_covered(parametrisation)) starts.push_back(parametrisation.start());
    if (!searches_whole()) add_best_known(problem, starts);
    for (LeastSquaresResult& start : begun_at(problem, starts)) searches.push_back(std::move(start));
    if (searched_.size() > 1) drop_distant(searches);
    return followed(problem, variant, std::move(searches));
  }

  /// Their work has been counted.
  static void forget_work(std::vector<LeastSquaresResult>& searches) {
    for (LeastSquaresResult& search : searches) search.work = {};
  }

  /// Adds the known model that is nearest to the whole record: a searched one may prefer another.
  void add_best_known(const OutputError& problem, std::vector<Eigen::VectorXd>& starts) {
    const KnownStarts known = known_starts(problem.parametrisation(), known_, scale_);
    std::vector<LeastSquaresResult> begun = begun_at(problem, known.at);
    for (const LeastSquaresResult& start : begun) work_["search"] += start.work;
    const auto least = std::min_element(begun.begin(), begun.end(), has_less_cost);
    if (least != begun.end() && least->termination != Termination::infeasible) starts.push_back(least->theta);
  }

  /// With a model that the caller may not want.
  [[nodiscard]] Patience patience() const { return options_.most_mse ? Patience::little : Patience::full; }

  /// Optima on the whole record. @param searches  on it, from where they were left
  std::vector<LocalOptimum> followed(const OutputError& problem, const Variant& variant,
                                     std::vector<LeastSquaresResult> searches) {
    const Parametrisation& parametrisation = problem.parametrisation();
    executor_(searches.size(), [&](std::size_t k) { proceed(problem, searches[k]); });
    // Valleys are flat where many coefficients are estimated.
    if (is_thinly_covered(parametrisation)) follow_down_all(problem, searches, patience());
    std::vector<LocalOptimum> optima;
    const std::size_t free = free_parameters(parametrisation, variant.linear);
    for (LeastSquaresResult& r : searches) {
      work_["refine"] += r.work;
      if (r.termination != Termination::infeasible) optima.push_back({variant, parametrisation, std::move(r), free});
    }
    return optima;
  }

  /// Whether a start in motion needs no search.
  [[nodiscard]] bool is_left_out(const Variant& variant, const std::vector<LocalOptimum>& found) {
    const MovingStart start{compared_, parametrisation_, variant, asked_, scale_.duration_s, known_};
    return options_.search == Search::known && is_needless(start, found, work_["search"]);
  }

  /// Turns to the structure behind its map. @param linear  optima without the map
  std::vector<LocalOptimum> followed_behind_valve(const std::vector<LocalOptimum>& linear) {
    asked_ = *behind_valve_;
    parametrisation_ = Parametrisation::search(asked_, scale_);
    std::vector<LocalOptimum> optima;
    for (const Variant& variant : variants(asked_, compared_.past().size(), rest_.has_value())) {
      if (is_left_out(variant, optima)) continue;
      const std::size_t free = free_parameters(parametrisation_, variant.linear);
      const OutputError rough(*searched_.front(), parametrisation_, variant.linear);
      std::vector<Eigen::VectorXd> guesses = valve_starts(linear, variant, parametrisation_, asked_, scale_);
      const KnownStarts known = known_starts(parametrisation_, known_, scale_);
      known.append_to(guesses);
      for (const LocalOptimum& other : optima) guesses.push_back(other.best.theta);
      const std::size_t most = linear.empty() ? kMostFollowedFromKnown : kMostBehindValve;
      SearchResult found = polished(rough, guesses, most == 1 ? Wanted::best : Wanted::distinct, executor_);
      work_["search"] += found.work;
      found.optima.resize(std::min(found.optima.size(), most));
      if (searches_whole()) {
        forget_work(found.optima);
        for (LeastSquaresResult& r : found.optima) optima.push_back({variant, parametrisation_, std::move(r), free});
        continue;
      }
      const OutputError problem(compared_, parametrisation_, variant.linear);
      std::vector<Eigen::VectorXd> starts;
      for (const LeastSquaresResult& optimum : found.optima) starts.push_back(optimum.theta);
      add_best_known(problem, starts);
      for (LocalOptimum& optimum : followed(problem, variant, begun_at(problem, starts))) {
        optima.push_back(std::move(optimum));
      }
    }
    return searches_whole() ? followed_if_likely(std::move(optima)) : optima;
  }

  /// Those of some rough optima on the whole record that may be chosen, followed to their ends: without strong evidence
  /// against them, or where the rough search was still under way.
  std::vector<LocalOptimum> followed_if_likely(std::vector<LocalOptimum> rough) {
    std::vector<LocalOptimum> optima;
    if (rough.empty()) return optima;
    const auto has_less = [](const LocalOptimum& a, const LocalOptimum& b) { return has_less_cost(a.best, b.best); };
    const LocalOptimum& closest = *std::min_element(rough.begin(), rough.end(), has_less);
    const double effective = residual_model(closest.best.point.residual).effective_samples;
    std::vector<double> bic;
    for (const LocalOptimum& o : rough) {
      bic.push_back(effective_bic(o.best.point.cost, o.best.point.residual.size(), o.free, effective));
    }
    const double least = *std::min_element(bic.begin(), bic.end());
    for (std::size_t k = 0; k < rough.size(); ++k) {
      const bool may_fall = !has_converged(rough[k].best.termination);
      if (!may_fall && !(bic[k] - least < kStrongEvidence)) continue;
      const OutputError problem(compared_, rough[k].parametrisation, rough[k].variant.linear);
      for (LocalOptimum& o : followed(problem, rough[k].variant, {std::move(rough[k].best)})) {
        optima.push_back(std::move(o));
      }
    }
    return optima;
  }

  /// The chosen optimum, or the closest one where a known model inside the structure is closer than the chosen one.
  [[nodiscard]] LocalOptimum no_worse_than_known(const std::vector<LocalOptimum>& optima, LocalOptimum chosen) const {
    const double least = least_known_error(chosen.parametrisation, known_);
    const auto rows = static_cast<double>(chosen.best.point.residual.size());
    if (!(chosen.best.point.cost > (1.0 + kNoWorse) * least * rows)) return chosen;
    return *std::min_element(optima.begin(), optima.end(), [](const LocalOptimum& a, const LocalOptimum& b) {
      return a.best.point.cost < b.best.point.cost;
    });
  }

  /// The least cost of a sub-structure, which a larger one may not exceed.
  [[nodiscard]] double most_cost_inside(const LocalOptimum& chosen) const {
    const double of_known =
        least_known_error(chosen.parametrisation, known_) * static_cast<double>(compared_.measured().size());
    return (1.0 + kNoWorse) * std::min(of_known, cost_without_map_);
  }

  /// Restores terms whose coefficient has vanished, and continues from the best of these starts if it is better.
  LocalOptimum with_terms_revived(LocalOptimum chosen) {
    const std::vector<Eigen::VectorXd> starts = revived(chosen.parametrisation, chosen.best.theta);
    if (starts.empty() || options_.search == Search::local) return chosen;
    const OutputError rough(*searched_.front(), chosen.parametrisation, chosen.variant.linear);
    const SearchResult found = polished(rough, starts, Wanted::best, executor_);
    work_["search"] += found.work;
    if (found.optima.empty()) return chosen;
    const OutputError problem(compared_, chosen.parametrisation, chosen.variant.linear);
    LeastSquaresResult again = minimise(problem, found.optima.front().theta);
    work_["refine"] += again.work;
    if (again.termination != Termination::infeasible && again.point.cost < chosen.best.point.cost) {
      chosen.best = std::move(again);
    }
    return chosen;
  }

  [[nodiscard]] LocalOptimum with_bias_named_if_integrating(const LocalOptimum& chosen) {
    const bool integrates = chosen.variant.linear.first_state < 0 && looks_integrating(chosen, scale_.duration_s);
    return integrates ? with_bias_named(chosen) : chosen;
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
    work_["refine"] += named.best.work;
    return named.best.termination == Termination::infeasible ? moving : named;
  }

  /// Goes on from the chosen optimum where its search used up its evaluations, as it does along a flat valley, until
  /// the cost no longer falls by what counts.
  LocalOptimum followed_to_its_end(LocalOptimum chosen) {
    const OutputError problem(compared_, chosen.parametrisation, chosen.variant.linear);
    for (int round = 0; round < kMostFurtherRounds; ++round) {
      if (chosen.best.termination != Termination::evaluation_limit) break;
      const double cost = chosen.best.point.cost;
      chosen.best.work = {};
      chosen.best = followed_down(problem, std::move(chosen.best), patience());
      work_["refine"] += chosen.best.work;
      const bool falls = chosen.best.point.cost < (1.0 - kNoWorse) * cost;
      if (!falls && chosen.best.termination == Termination::evaluation_limit) {
        chosen.best.termination = Termination::flat_ridge;
      }
    }
    return chosen;
  }

  [[nodiscard]] FitResult report(const LocalOptimum& chosen) const {
    return report_of(chosen, {.prepared = prepared_,
                              .compared = compared_,
                              .options = options_,
                              .executor = executor_,
                              .given = given_,
                              .asked = asked_,
                              .scale = scale_,
                              .rests_before = rest_ && !bias_asked_,
                              .work = work_});
  }

  const PreparedRecord& prepared_;
  const Record& record_;
  StructureOptions given_;
  const FitOptions& options_;
  const Executor& executor_;
  const std::vector<Model>& known_;  ///< fitted to the same record
  FitRows rows_;
  std::optional<double> rest_;  ///< level before a step test [input unit]
  bool bias_asked_;
  std::optional<StructureOptions> behind_valve_;  ///< what is asked, where its structure has a valve map
  StructureOptions asked_;                        ///< without the map until followed_behind_valve()
  bool past_;
  const ComparedRecord& compared_;
  std::vector<const ComparedRecord*> searched_;
  std::optional<std::vector<PoleGuess>> guesses_;
  Parametrisation::Scale scale_;  ///< the estimating part sets it
  Parametrisation parametrisation_;
  double cost_without_map_ = std::numeric_limits<double>::infinity();  ///< behind a map, the least without it
  WorkByStage work_;
};

}  // namespace

FitResult with_profiles(const PreparedRecord& prepared, const FitResult& fitted, const FitOptions& options,
                        const Executor& executor) {
  FitOptions profiled = options;
  profiled.intervals = IntervalMethod::profile;
  profiled.reported = Reported::everything;
  FitResult result = DefaultFit(prepared, fitted.fitted->asked, profiled, executor, {}).again(*fitted.fitted);
  result.model.estimation->evaluations += fitted.model.estimation->evaluations;
  result.model.estimation->seconds = fitted.model.estimation->seconds;
  for (const auto& [name, note] : fitted.model.provenance) result.model.provenance.try_emplace(name, note);
  return result;
}

FitResult fit_by_default(const PreparedRecord& prepared, const StructureOptions& asked, const FitOptions& options,
                         const Executor& executor, const std::vector<Model>& known) {
  return DefaultFit(prepared, asked, options, executor, known).run();
}

}  // namespace eha::ident
