// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/ladder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

#include "core/error.hpp"
#include "ident/estimation/default_procedure.hpp"
#include "ident/estimation/delay_gain.hpp"
#include "ident/estimation/fit_report.hpp"
#include "ident/estimation/fitted_optimum.hpp"
#include "ident/estimation/ladder_fits.hpp"
#include "ident/estimation/left_out.hpp"
#include "ident/estimation/optimum_report.hpp"
#include "ident/estimation/rungs.hpp"
#include "ident/estimation/sub_structures.hpp"
#include "ident/estimation/valve_gain.hpp"
#include "ident/structure/parameter_requests.hpp"

namespace eha::ident {
namespace {

constexpr double kDelayGain = 10.0;     // of AR-BIC
constexpr double kPredictedGain = 0.0;  // of it, for which a delay is searched
constexpr int kMostProfiled = 3;        // rounds: a profile may reject the model that was to be recommended
constexpr double kMissing = 0.001;  // level of the residual's test with past input, for a zero beside fractional orders
constexpr double kAlmost = 2.0;     // times the error of the best, for a search of poles beside a dead time
constexpr int kMostZeroed = 2;      // coefficients of one model that are set to 0
constexpr double kCoefficientCost = 10.0;  // more than AR-BIC charges for one
// A structure behind a map is worth a whole search if it could come that near to the best two models, were the map to
// gain that many times what is predicted. Measured gains beyond 20 were at most 5 times those predicted.
constexpr double kFarFromSecond = 50.0;  // of AR-BIC
constexpr double kFarFromBest = 150.0;
constexpr double kUnderestimated = 5.0;
constexpr std::size_t kMostSharedRows = 1'000'000;  // of which two fits at once stay within the memory of one of 10^7

bool has(const Structure& structure, const std::string& parameter) {
  const auto all = requestable_parameters(structure);
  return std::any_of(all.begin(), all.end(), [&](const StructureParameter* p) { return p->key.name == parameter; });
}

/// The estimated coefficient whose interval holds 0 and whose value is the fewest standard errors from it; null
/// without.
const ParameterEstimate* most_compatible_with_0(const Model& model) {
  const ParameterEstimate* most = nullptr;
  const auto distance = [](const ParameterEstimate& p) { return std::abs(p.value) / p.std; };
  for (const ParameterEstimate& p : model.parameters) {
    if (p.fixed || !is_coefficient(p.role) || p.lower95 > 0.0 || p.upper95 < 0.0) continue;
    if (most == nullptr || distance(p) < distance(*most)) most = &p;
  }
  return most;
}

class Climber {
 public:
  Climber(const PreparedRecord& prepared, const LadderOptions& wanted, const FitOptions& options,
          const LadderLimits& limits, const FitStructure& fit_structure, const Executor& executor)
      : prepared_(prepared),
        wanted_(wanted),
        options_(options),
        limits_(limits),
        fits_(options, limits, fit_structure),
        executor_(executor) {}

  Climb run() {
    for (const InputMapKind& map : input_map_kinds()) {
      if (wanted_.input_map != nullptr && wanted_.input_map != &map) continue;
      for (const FitStage& stage : stages_of(wanted_)) fit_stage(stage, map);
    }
    if (climb_.models.empty() && left_.first_failure) std::rethrow_exception(left_.first_failure);
    check_requests_used();
    set_coefficients_to_0();
    try_zero_beside_fractional_orders();
    if (!wanted_.delay && try_delays()) {
      search_poles_beside_delays();
      set_coefficients_to_0();
    }
    recommend_finished();
    climb_.refused = std::move(left_.refused);
    climb_.work = std::move(left_.work);
    return std::move(climb_);
  }

 private:
  [[nodiscard]] StructureOptions asked_for(const Rung& rung, const Structure& structure,
                                           const InputMapKind& map) const {
    StructureOptions asked;
    asked.name = rung.name + std::string(map.suffix);
    asked.structure = map.put_before(structure);
    asked.initial_state = wanted_.initial_state;
    if (wanted_.delay) asked.structure.delay = *wanted_.delay;
    for (const ParameterRequest& request : wanted_.parameters) {
      if (has(asked.structure, request.name)) asked.parameters.push_back(request);
    }
    return asked;
  }

  void check_requests_used() const {
    for (const ParameterRequest& request : wanted_.parameters) {
      const bool used = std::any_of(climb_.models.begin(), climb_.models.end(), [&](const ClimbedModel& climbed) {
        return has(climbed.structure.structure, request.name);
      });
      if (!used) throw ConfigError(fmt::format("parameter {}: no structure of the ladder has it", request.name));
    }
  }

  /// The AR-BIC beyond which a model can be neither recommended nor the runner-up. One of integer order has those of
  /// integer order for rivals, which orders that are estimated need not displace.
  [[nodiscard]] double end_of_reach(const ClimbedModel& climbed) const {
    return end_of_reach(has_estimated_order(climbed.result.model));
  }
  [[nodiscard]] double end_of_reach(bool fractional) const {
    std::vector<double> rivals(2, std::numeric_limits<double>::infinity());
    for (const ClimbedModel& climbed : climb_.models) {
      if (!fractional && has_estimated_order(climbed.result.model)) continue;
      if (fits_.is_identified(climbed)) rivals.push_back(ar_bic(climbed));
    }
    std::sort(rivals.begin(), rivals.end());
    return std::min(rivals[0] + kFarFromBest, rivals[1] + kFarFromSecond);
  }

  /// @param gain  predicted, of a change
  [[nodiscard]] static bool is_beyond(double end, double ar_bic, double gain) {
    return ar_bic - kUnderestimated * gain > end;
  }

  /// Whether the structure behind a map can be neither recommended nor the runner-up, whatever the map.
  [[nodiscard]] bool is_out_of_reach(const StructureOptions& behind_map, const StructureOptions& plain,
                                     WorkByStage& work) const {
    const auto found = left_.optima.find(signature(plain));
    if (found == left_.optima.end() || !found->second.optimum) return false;
    const double end = end_of_reach(found->second.is_fractional);
    if (!is_beyond(end, found->second.ar_bic, 0.0)) return false;
    const double gain = predicted_valve_gain(prepared_, *found->second.optimum, behind_map, work["search"]);
    return is_beyond(end, found->second.ar_bic, gain);
  }

  [[nodiscard]] Search search_of(const Rung& rung, const Structure& structure, const StructureOptions& asked,
                                 WorkByStage& work) const {
    // Behind a map every structure starts from its own fit without one.
    const bool is_known = std::any_of(climb_.models.begin(), climb_.models.end(),
                                      [&](const ClimbedModel& m) { return m.structure.name == rung.name; });
    if (!asked.structure.input_map.valve) return is_known ? Search::known : rung.search;
    const StructureOptions plain = asked_for(rung, structure, input_map_kinds().front());
    if (is_out_of_reach(asked, plain, work)) return Search::nearest;
    return is_known ? Search::known : rung.search;
  }

  /// What the fits of one chain add.
  struct Added {
    std::vector<Model> known;  ///< what later fits start from
    std::vector<ClimbedModel> models;
    LeftByFits left;
  };

  /// Runs tasks at the same time, unless the record is so long that two fits may not fit the memory.
  template <typename Task>
  void at_once(std::size_t count, const Task& task) const {
    if (prepared_.rows.last < kMostSharedRows) {
      executor_(count, task);
    } else {
      run_in_order(count, task);
    }
  }

  void fit_stage(const FitStage& stage, const InputMapKind& map) {
    std::vector<Added> added(stage.size());
    const auto fit_chain = [&](std::size_t k) {
      for (const Rung& rung : stage[k]) fit_rung(rung, map, added[k]);
    };
    at_once(stage.size(), fit_chain);
    for (Added& chain : added) {
      std::move(chain.known.begin(), chain.known.end(), std::back_inserter(known_));
      std::move(chain.models.begin(), chain.models.end(), std::back_inserter(climb_.models));
      left_ += std::move(chain.left);
    }
  }

  void fit_rung(const Rung& rung, const InputMapKind& map, Added& added) const {
    std::optional<ClimbedModel> best;
    for (const Structure& structure : rung.structures) {
      const StructureOptions asked = asked_for(rung, structure, map);
      const Search search = search_of(rung, structure, asked, added.left.work);
      std::vector<Model> known = known_;
      known.insert(known.end(), added.known.begin(), added.known.end());
      auto climbed = fits_.fitted(asked, search, known, added.left);
      if (!climbed) continue;
      added.known.push_back(climbed->result.model);
      if (!best || fits_.is_preferred(*climbed, *best)) best = std::move(climbed);
    }
    if (best) added.models.push_back(std::move(*best));
  }

  /// The model of least AR-BIC of those; null without one.
  template <typename Which>
  ClimbedModel* best_of(const Which& which) {
    ClimbedModel* best = nullptr;
    for (ClimbedModel& climbed : climb_.models) {
      if (which(climbed) && (best == nullptr || ar_bic(climbed) < ar_bic(*best))) best = &climbed;
    }
    return best;
  }

  /// Whether the residual of the best model depends on past input.
  bool misses_a_part() {
    complete_all();
    const ClimbedModel* best = best_of([](const ClimbedModel&) { return true; });
    if (best == nullptr || !best->result.model.validation) return false;
    const auto& tests = best->result.model.validation->tests;
    return tests && tests->input.p < kMissing;
  }

  /// A zero takes two more searches of fractional orders, which most records need not.
  void try_zero_beside_fractional_orders() {
    if (!misses_a_part()) return;
    for (ClimbedModel& climbed : climb_.models) {
      if (climbed.structure.structure.family != "fo" || !climbed.structure.parameters.empty()) continue;
      StructureOptions asked = climbed.structure;
      const Structure with_zero = structures::fo_with_zero();
      asked.structure.numerator = with_zero.numerator;
      asked.structure.denominator = with_zero.denominator;
      asked.structure.formula = with_zero.formula;
      auto fit = fits_.fitted(asked, Search::known, known_, left_);
      if (!fit || !fits_.is_preferred(*fit, climbed)) continue;
      known_.push_back(fit->result.model);
      climbed = std::move(*fit);
    }
  }

  /// @returns whether the delay stays, and is new
  bool try_delay(ClimbedModel& climbed, Search search) {
    if (is_estimated(climbed.structure, climbed.structure.structure.delay)) return false;
    StructureOptions asked = climbed.structure;
    asked.structure.delay.freedom = Freedom::free;
    const std::vector<Model> own = {climbed.result.model};
    std::vector<Model> known = delayed_;
    known.insert(known.end(), own.begin(), own.end());
    auto delayed = fits_.fitted(asked, search, known, left_);
    if (search == Search::nearest && !delayed_.empty()) {
      // A delay that does all the work of a lag leaves the lag no slope: the nearest start may be such a one.
      auto from_own = fits_.fitted(asked, search, own, left_);
      if (from_own && (!delayed || ar_bic(*from_own) < ar_bic(*delayed))) delayed = std::move(from_own);
    }
    if (!delayed || !(ar_bic(*delayed) <= ar_bic(climbed) - kDelayGain)) return false;
    if (search != Search::nearest) delayed_.push_back(delayed->result.model);
    climbed = std::move(*delayed);
    return true;
  }

  /// How to search for a delay: by prediction, and as found from the nearest start, it may be worth a whole search.
  /// @returns nothing where it promises no gain
  [[nodiscard]] std::optional<Search> search_for_delay(const ClimbedModel& climbed) {
    const auto& found = climbed.result.fitted;
    if (!found) return Search::known;
    const double gain = predicted_delay_gain(prepared_, *found, left_.work["search"]);
    if (!(gain > kPredictedGain)) return std::nullopt;
    if (is_beyond(end_of_reach(climbed), ar_bic(climbed), gain)) return Search::nearest;
    StructureOptions asked = climbed.structure;
    asked.structure.delay.freedom = Freedom::free;
    const auto near = fits_.fitted(asked, Search::nearest, {climbed.result.model}, left_);
    return near && !(ar_bic(*near) < ar_bic(climbed)) ? std::nullopt : std::optional(Search::known);
  }

  /// Whether the model is the best of those of integer or of fractional order, as it is.
  bool is_best_of_its_kind(const ClimbedModel& climbed) {
    const bool is_fractional = has_estimated_order(climbed.result.model);
    return best_of([&](const ClimbedModel& m) { return has_estimated_order(m.result.model) == is_fractional; }) ==
           &climbed;
  }

  /// @returns whether a model has one now
  bool try_delays() {
    bool any = false;
    bool changes_the_best = false;
    std::vector<ClimbedModel*> first = {
        best_of([](const ClimbedModel& m) { return m.structure.structure.family == "io1"; }),
        best_of([](const ClimbedModel& m) { return !has_estimated_order(m.result.model); }),
        best_of([](const ClimbedModel& m) { return has_estimated_order(m.result.model); })};
    for (ClimbedModel* climbed : first) {
      if (climbed == nullptr) continue;
      const std::optional<Search> search = search_for_delay(*climbed);
      if (!search || !try_delay(*climbed, *search)) continue;
      any = true;
      changes_the_best = changes_the_best || is_best_of_its_kind(*climbed);
    }
    if (!changes_the_best) return any;
    for (ClimbedModel& climbed : climb_.models) {
      if (try_delay(climbed, Search::nearest) && !is_beyond(end_of_reach(climbed), ar_bic(climbed), 0.0)) {
        search_anew(climbed);
      }
    }
    return true;
  }

  /// Where a part is missing beside a dead time, that may stand for two poles that no search from a known model finds:
  /// the structures of integer order that err hardly more than the best are searched whole.
  void search_poles_beside_delays() {
    if (!misses_a_part()) return;
    const ClimbedModel* best = best_of([](const ClimbedModel&) { return true; });
    const double most = kAlmost * kAlmost * best->result.model.estimation->score.mse;
    std::vector<ClimbedModel*> near;
    for (ClimbedModel& climbed : climb_.models) {
      const Model& model = climbed.result.model;
      const bool has_resonance = state_count(climbed.structure.structure) > 2;
      if (is_estimated(climbed.structure, climbed.structure.structure.delay) && !has_estimated_order(model) &&
          has_resonance && model.estimation->score.mse <= most) {
        near.push_back(&climbed);
      }
    }
    std::vector<LeftByFits> left(near.size());
    at_once(near.size(), [&](std::size_t k) {
      auto anew = fits_.fitted(near[k]->structure, Search::global, {near[k]->result.model}, left[k]);
      if (anew && ar_bic(*anew) < ar_bic(*near[k])) *near[k] = std::move(*anew);
    });
    for (LeftByFits& one : left) left_ += std::move(one);
  }

  /// The least AR-BIC that is identified; infinite without one.
  [[nodiscard]] double least_identified() const {
    double least = std::numeric_limits<double>::infinity();
    for (const ClimbedModel& climbed : climb_.models) {
      if (fits_.is_identified(climbed)) least = std::min(least, ar_bic(climbed));
    }
    return least;
  }

  /// Replaces a model that only coefficients compatible with 0 keep from being identified by the structure without
  /// them, where that may be the best one and was not fitted yet. @returns whether it was replaced
  bool set_coefficients_to_0(ClimbedModel& climbed, double least) {
    if (fits_.is_identified(climbed)) return false;
    std::optional<ClimbedModel> smaller = climbed;
    for (int k = 0; smaller && k < kMostZeroed && !fits_.is_identified(*smaller); ++k) {
      smaller = ar_bic(*smaller) < least + kMostZeroed * kCoefficientCost ? without_least(*smaller) : std::nullopt;
    }
    if (!smaller || !fits_.is_identified(*smaller)) return false;
    climbed = std::move(*smaller);
    return true;
  }

  void set_coefficients_to_0() {
    const double least = least_identified();
    for (ClimbedModel& climbed : climb_.models) set_coefficients_to_0(climbed, least);
  }

  /// The model without the coefficient that is most compatible with 0; nothing where that says no more than a
  /// structure that was fitted.
  std::optional<ClimbedModel> without_least(const ClimbedModel& climbed) {
    if (!fits_.is_right_but_for_parameters(climbed)) return {};
    const ParameterEstimate* zero = most_compatible_with_0(climbed.result.model);
    if (zero == nullptr) return {};
    const std::size_t terms = climbed.result.model.transfer_function.numerator.size();
    const auto asked = without_coefficient(climbed.structure, key_of(zero->name, terms));
    if (!asked || left_.signatures.contains(signature(*asked))) return {};
    return fits_.fitted(*asked, Search::known, {climbed.result.model}, left_);
  }

  /// Judges the models by the part of the record that does not estimate, too.
  void complete_all() {
    at_once(climb_.models.size(), [&](std::size_t k) {
      ClimbedModel& climbed = climb_.models[k];
      if (is_complete(climbed.result)) return;
      complete_report(climbed.result, prepared_, Effects::leave_out);
      fits_.judge_anew(climbed);
    });
  }

  void recommend_anew() {
    complete_all();
    std::vector<const Model*> models;
    for (const ClimbedModel& climbed : climb_.models) models.push_back(&climbed.result.model);
    climb_.recommendation = recommend(models, limits_.acceptance, limits_.facts.unmeasured);
  }

  /// The models of the ladder, among which are those without the terms of a model's free orders.
  [[nodiscard]] std::vector<FittedStructure> fitted_structures() const {
    std::vector<FittedStructure> structures;
    for (const ClimbedModel& climbed : climb_.models) {
      structures.push_back({signature(climbed.structure), ar_bic(climbed)});
    }
    return structures;
  }

  /// Of a model that was out of reach before others were rejected.
  void search_anew(ClimbedModel& climbed) {
    std::vector<Model> known = known_;
    known.insert(known.end(), delayed_.begin(), delayed_.end());
    known.push_back(climbed.result.model);
    if (auto anew = fits_.fitted(climbed.structure, Search::known, known, left_)) climbed = std::move(*anew);
  }

  void add_profiles(const std::vector<ClimbedModel*>& wanted) {
    const std::vector<FittedStructure> structures = fitted_structures();
    std::vector<WorkByStage> work(wanted.size());
    at_once(wanted.size(), [&](std::size_t k) {
      ClimbedModel& climbed = *wanted[k];
      const FitResult& plain = climbed.result;
      if (plain.fitted == nullptr) return;
      FitResult profiled = with_profiles(prepared_, plain, options_, executor_);
      note_left_out(profiled, prepared_, plain.fitted->asked, options_, executor_, structures);
      work[k] = profiled.work;
      add(profiled.work, plain.work);
      climbed.result = std::move(profiled);
      fits_.judge_anew(climbed);
    });
    for (const WorkByStage& of_one : work) add(left_.work, of_one);
  }

  /// The recommended model and the runner-up, without those that are finished.
  [[nodiscard]] std::vector<ClimbedModel*> wanted_finished(std::set<std::string>& finished) {
    std::vector<ClimbedModel*> wanted;
    for (ClimbedModel& climbed : climb_.models) {
      const std::string& name = climbed.result.model.name;
      const bool is_wanted = name == climb_.recommendation.model || name == climb_.recommendation.runner_up;
      if (is_wanted && finished.insert(name).second) wanted.push_back(&climbed);
    }
    return wanted;
  }

  /// Searches the recommended model and the runner-up whole and, where asked, adds their profiles.
  void recommend_finished() {
    const bool profiles = options_.intervals == IntervalMethod::profile;
    recommend_anew();
    std::set<std::string> finished;
    for (int round = 0; round < kMostProfiled; ++round) {
      const std::vector<ClimbedModel*> wanted = wanted_finished(finished);
      bool any = profiles && !wanted.empty();
      for (ClimbedModel* climbed : wanted) {
        any = any || climbed->is_rough;
        if (climbed->is_rough) search_anew(*climbed);
      }
      if (profiles) add_profiles(wanted);
      // A profile may show that a coefficient is compatible with 0.
      const double least = least_identified();
      for (ClimbedModel* climbed : wanted) {
        if (set_coefficients_to_0(*climbed, least)) finished.erase(climbed->result.model.name);
      }
      if (!any) break;
      recommend_anew();
    }
    if (profiles) test_the_good_for_nonlinear_effects();
  }

  /// The test belongs to a profiled model; the others are spared its simulations unless they would be called good.
  void test_the_good_for_nonlinear_effects() {
    for (ClimbedModel& climbed : climb_.models) {
      Model& model = climbed.result.model;
      const bool is_tested = model.validation && model.validation->tests && model.validation->tests->nonlinearity;
      if (is_tested || !model.verdict || model.verdict->grade != Grade::good) continue;
      fill_validation(climbed.result, prepared_.facts, prepared_.rows.comparison, Effects::include);
      fits_.judge_anew(climbed);
    }
  }

  const PreparedRecord& prepared_;
  const LadderOptions& wanted_;
  const FitOptions& options_;
  const LadderLimits& limits_;
  LadderFits fits_;
  const Executor& executor_;
  Climb climb_;
  std::vector<Model> known_;
  LeftByFits left_;
  std::vector<Model> delayed_;
};

}  // namespace

Climb climb(const PreparedRecord& prepared, const LadderOptions& wanted, const FitOptions& options,
            const LadderLimits& limits, const FitStructure& fit_structure, const Executor& executor) {
  return Climber(prepared, wanted, options, limits, fit_structure, executor).run();
}

}  // namespace eha::ident
