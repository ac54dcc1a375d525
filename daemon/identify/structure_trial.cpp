// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/structure_trial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/identify/judging.hpp"
#include "daemon/identify/shaped_record_trial.hpp"
#include "daemon/identify/trial.hpp"
#include "ident/estimation/prepared_record.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/record.hpp"
#include "ident/statistics/robust.hpp"
#include "ident/structure/structures.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/explanation.hpp"
#include "ident/validation/fast_resonance.hpp"
#include "ident/validation/recommendation.hpp"
#include "ident/validation/slow_pair.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::identify {
namespace {

using Kind = ident::CriterionKind;

constexpr double kFarLess = 0.5;                      // of an error on unseen data, of a structure that explains it
constexpr double kOtherPart = 4.0;                    // times an error, what the two parts may differ by
constexpr double kMostWithoutMap = 0.25;              // of the least error without a map, of one behind it
constexpr Eigen::Index kMostSimulatedRows = 200'000;  // a grey box simulates each of them some 500 times
constexpr std::array kMoreDegrees{ident::Degrees{3, 2}, ident::Degrees{4, 2}, ident::Degrees{4, 3}};
constexpr std::array kMoreBesideIntegrator{ident::Degrees{3, 2}, ident::Degrees{4, 2}, ident::Degrees{5, 2}};

std::vector<ident::Model> models_of(const Identification& identification) {
  std::vector<ident::Model> models;
  for (const IdentifiedModel& one : identification.models) models.push_back(one.result.model);
  return models;
}

/// @param most_mse  of the estimating part, beyond which the trial is of no use
std::optional<Trial> trial_of(const IdentificationTask& task, const ident::PreparedRecord& prepared,
                              const Identification& identification, const ident::GreyBoxKind& kind, double most_mse) {
  ident::StructureOptions asked;
  asked.name = std::string(kind.name);
  asked.structure = ident::structures::grey_box(kind);
  const std::vector<ident::Model> known = models_of(identification);
  std::optional<ident::Model> model = fit_that_holds(task, prepared, asked, {task.options.search, known, most_mse});
  if (!model) return std::nullopt;
  return Trial{std::move(*model), {.has = std::string(kind.effect), .options = fmt::format("--model {}", kind.name)}};
}

/// Whether a residual test finds a part of the plant in what a model leaves over.
bool misses_a_part(const ident::Verdict& verdict) {
  return ident::fails_any(
      verdict, {Kind::residual_input, Kind::nonlinearity, Kind::error_over_noise, Kind::far_error_over_noise});
}

constexpr double kLeastDamping = 0.005;

/// The mean square error of the estimating part that a trial may have at most and still err clearly less than the model
/// on the other part, however the two parts differ.
double useful_mse(const ident::Model& model) {
  constexpr double kMost = kOtherPart * kClearlyLess;
  const double estimating = model.estimation ? model.estimation->score.mse : 0.0;
  return kMost * kMost * std::max(estimating, ident::shown_mse(model));
}

/// The first of more poles and zeros that leaves nothing over, else the one that errs least; none that holds.
std::optional<Trial> trial_of_more_poles(const IdentificationTask& task, const ident::PreparedRecord& prepared,
                                         const Identification& identification, const ident::Model& first) {
  const std::vector<ident::Model> known = models_of(identification);
  const bool has_delay = first.transfer_function.delay_s > 0.0;
  const bool integrates = first.stability && first.stability->integrator_order > 0.0;
  std::optional<Trial> best;
  for (const ident::Degrees& degrees : integrates ? kMoreBesideIntegrator : kMoreDegrees) {
    ident::StructureOptions asked;
    asked.structure = ident::structures::io(degrees);
    if (has_delay) asked.structure.delay.freedom = ident::Freedom::free;
    if (integrates) asked.parameters.push_back({.name = "a0", .fixed = true, .start = 0.0, .lower = {}, .upper = {}});
    std::optional<ident::Model> model =
        fit_that_holds(task, prepared, asked, {ident::Search::known, known, useful_mse(first)});
    // Play and friction make a pair of poles that hardly dies away of a plant without one; oil and mass damp more.
    if (!model || ident::least_damping(*model) < kLeastDamping) continue;
    const bool is_clean = !misses_a_part(*model->verdict);
    if (!is_clean && best && !(ident::shown_mse(*model) < ident::shown_mse(best->model))) continue;
    best = Trial{std::move(*model),
                 {.has = fmt::format("{} poles and {} zeros", degrees.poles, degrees.zeros),
                  .options = fmt::format("--model io --poles {} --zeros {}{}{}", degrees.poles, degrees.zeros,
                                         has_delay ? " --delay free" : "", integrates ? " --fix a0=0" : "")}};
    if (is_clean) break;
  }
  return best;
}

/// Whether a trial explains what a model leaves over.
bool explains(const ident::Model& trial, const ident::Model& model) {
  const std::optional<double> over = ident::error_over(trial, model);
  return over && (*over <= kFarLess || (*over <= kClearlyLess && !misses_a_part(*trial.verdict)));
}

/// The model that stands first in the table: the recommended one, that beside it, or the one that errs least.
const ident::Model* first_of_table(const Identification& identification) {
  const ident::Recommendation& recommendation = identification.recommendation;
  const std::string& name = recommendation.model.empty() ? recommendation.runner_up : recommendation.model;
  const ident::Model* first = nullptr;
  for (const IdentifiedModel& one : identification.models) {
    const ident::Model& model = one.result.model;
    if (!model.validation || !model.verdict) continue;
    if (model.name == name) return &model;
    if (first == nullptr || model.validation->score.mse < first->validation->score.mse) first = &model;
  }
  return first;
}

/// Whether an accepted model errs as little as a trial, so that it makes up for it.
bool is_made_up_for(const Identification& identification, const ident::Model& trial) {
  return std::any_of(identification.models.begin(), identification.models.end(), [&](const IdentifiedModel& one) {
    const std::optional<double> over = ident::error_over(trial, one.result.model);
    return is_accepted(one) && over && *over > kClearlyLess;
  });
}

/// Whether the kind may be fitted beside a model, and was not.
bool is_wanted(const Identification& identification, const ident::GreyBoxKind* kind) {
  return kind != nullptr &&
         std::none_of(identification.models.begin(), identification.models.end(), [&](const IdentifiedModel& one) {
           const auto& box = one.result.model.grey_box;
           return box && box->kind == kind;
         });
}

/// Whether what the kind has may be what a model of the table misses.
bool may_be_explained_by(const ident::GreyBoxKind& kind, const ident::Model& model, const ident::Model* first) {
  return model.verdict && (&model == first || ident::grey_box_to_try(model, *model.verdict) == &kind);
}

/// Whether more poles may describe what the first model misses: whatever its error looks like, but for one that
/// lies in the record.
bool wants_more_poles(const ident::Model& first) {
  if (first.grey_box || ident::takes_in_a_drift(*first.verdict)) return false;
  if (ident::error_cause(first, *first.verdict) == ident::ErrorCause::frozen) return false;
  return misses_a_part(*first.verdict) || ident::fails_any(*first.verdict, {Kind::r2});
}

/// Whether so little is left of the error behind a map that no poles without it make up for it.
bool is_made_by_map(const Identification& identification, const ident::Model& first) {
  if (!first.input_map || !first.estimation) return false;
  const auto mse = [](const ident::Model& model) { return model.estimation->score.mse; };
  double least = std::numeric_limits<double>::infinity();
  double least_shown = std::numeric_limits<double>::infinity();
  for (const IdentifiedModel& one : identification.models) {
    const ident::Model& model = one.result.model;
    if (model.input_map || model.grey_box || !model.estimation) continue;
    least = std::min(least, mse(model));
    least_shown = std::min(least_shown, ident::shown_mse(model));
  }
  constexpr double kMost = kMostWithoutMap * kMostWithoutMap;
  return std::isfinite(least) && mse(first) <= kMost * least && ident::shown_mse(first) <= kMost * least_shown;
}

/// The way of the gain as the input grows, where the level of the input changes it.
std::optional<ident::GainTrend> trend_of_gain(const ident::Model& first) {
  if (first.grey_box || !first.validation || !first.validation->tests || first.validation->end_stop)
    return std::nullopt;
  const auto& effect = first.validation->tests->nonlinearity;
  const bool is_level = effect && ident::nonlinear_kind(first, *first.verdict) == ident::NonlinearKind::level;
  return is_level ? effect->gain : ident::GainTrend::unknown;
}

/// Whether a power of the input may be what the first model misses: its gain depends on the level of the input.
bool may_be_curved(const ident::Model& first) {
  const std::optional<ident::GainTrend> trend = trend_of_gain(first);
  return trend && (*trend != ident::GainTrend::unknown ||
                   (!first.validation->jump && !first.verdict->accepted && wants_more_poles(first)));
}

/// Whether a limit of the input may be what the first model misses: its gain falls as the input grows, or it follows
/// so little that no test tells.
bool may_saturate(const ident::Model& first) {
  const std::optional<ident::GainTrend> trend = trend_of_gain(first);
  if (!trend) return false;
  const bool falls = *trend == ident::GainTrend::falls;
  // An error that jumps is a sensor's, unless the gain says otherwise: behind a rod that integrates each motion that is
  // cut short by a limit leaves a step.
  return falls || (!first.validation->jump && !first.verdict->accepted && wants_more_poles(first));
}

/// Whether a play may be what the first model errs by: it errs several times as much as the sensor's readings scatter
/// from row to row, whatever the tests say.
bool may_have_play(const IdentificationTask& task, const ident::Model& first) {
  constexpr double kOverScatter = 3.0;
  constexpr Eigen::Index kFewest = 300;
  const Eigen::VectorXd& y = task.record.output;
  if (first.grey_box || !first.verdict->accepted || !first.validation || y.size() < kFewest) return false;
  if (first.validation->end_stop || first.validation->jump || ident::rounding_makes_most(first)) return false;
  const double scatter = ident::scatter_of_rows(y);
  return ident::shown_mse(first) > kOverScatter * kOverScatter * scatter * scatter;
}

/// Notes that the trial explains what the models leave over, where it errs clearly less than they do.
void note_on_models(const Trial& trial, Identification& identification) {
  const ident::ValidationReport& seen = *trial.model.validation;
  for (IdentifiedModel& one : identification.models) {
    ident::Model& model = one.result.model;
    const std::optional<double> over = ident::error_over(trial.model, model);
    if (!over || *over > kClearlyLess) continue;
    ident::Explanation explanation = trial.explanation;
    explanation.ratio = ident::figure_text(*over);
    ident::note_explanation(model, explanation);
    // What it follows is none of the record's.
    if (!seen.end_stop) {
      model.validation->end_stop.reset();
      model.validation->saturated_percent = seen.saturated_percent;
    }
    if (!seen.jump) model.validation->jump.reset();
    if (!trial.model.provenance.contains(ident::kGainChanged)) {
      model.provenance.erase(ident::kGainChanged);
      model.provenance.erase(ident::kBesideGainChange);
    }
    if (!model.validation->jump && !model.provenance.contains(ident::kGainChanged)) {
      model.provenance.erase(ident::kLongerPart);
    }
    if (!model.validation->end_stop && !model.validation->jump) model.provenance.erase(ident::kCutOfRecord);
  }
}

}  // namespace

void try_other_structures(const IdentificationTask& task, Identification& identification, const Progress& progress) {
  if (task.options.procedure == ident::Procedure::paper || task.record.input.size() > kMostSimulatedRows) return;
  if (!task.slow_rows.empty() || is_loop_noted(identification)) return;
  std::set<const ident::GreyBoxKind*> kinds;
  const ident::Model* first = first_of_table(identification);
  const ident::GreyBoxKind* left = first == nullptr ? nullptr : ident::grey_box_left_to_try(*first, *first->verdict);
  for (const IdentifiedModel& one : identification.models) {
    const ident::Model& model = one.result.model;
    const ident::GreyBoxKind* kind = model.verdict ? ident::grey_box_to_try(model, *model.verdict) : nullptr;
    if (is_wanted(identification, kind)) kinds.insert(kind);
  }
  const bool is_asked = kinds.contains(left);
  if (is_wanted(identification, left)) kinds.insert(left);
  std::optional<Trial> best;
  const auto keep_better = [&](std::optional<Trial> trial) {
    if (!trial || first == nullptr || !explains(trial->model, *first)) return;
    if (!best || ident::shown_mse(trial->model) < ident::shown_mse(best->model)) best = std::move(trial);
  };
  bool any = false;
  const double trials =
      static_cast<double>(kinds.size()) + 4.0;  // more poles, a play, a limit and a power of the input
  double begun = 0.0;
  const auto say = [&](const std::string& what) {
    if (progress && begun <= 0.0) progress(0.0, "what the models leave over: structures beside the ladder are tried\n");
    if (progress) progress(begun++ / trials, "trying " + what);
  };
  const ident::PreparedRecord prepared(task.record, task.options);
  for (const ident::GreyBoxKind* kind : kinds) {
    say(std::string(kind->effect));
    double most_mse = 0.0;
    for (const IdentifiedModel& one : identification.models) {
      if (may_be_explained_by(*kind, one.result.model, first))
        most_mse = std::max(most_mse, useful_mse(one.result.model));
    }
    std::optional<Trial> trial = trial_of(task, prepared, identification, *kind, most_mse);
    if (!trial) continue;
    const ident::Model& box = trial->model;
    const bool helps_first = kind == left && (is_asked || !is_made_up_for(identification, box));
    for (IdentifiedModel& one : identification.models) {
      ident::Model& model = one.result.model;
      const bool is_first = &model == first && helps_first;
      if (!model.verdict || (!is_first && ident::grey_box_to_try(model, *model.verdict) != kind)) continue;
      const std::optional<double> over = ident::error_over(box, model);
      if (!over || *over > kClearlyLess) continue;
      model.provenance[ident::kGreyBoxHolds] = fmt::format("errs {} times as much", ident::figure_text(*over));
      any = true;
      if (&model == first) keep_better(trial);
    }
  }
  const bool is_explained = best && !misses_a_part(*best->model.verdict);
  if (first != nullptr && !is_explained && wants_more_poles(*first) && !is_made_by_map(identification, *first)) {
    say("more poles");
    std::optional<Trial> trial = trial_of_more_poles(task, prepared, identification, *first);
    if (trial && !is_made_up_for(identification, trial->model)) keep_better(std::move(trial));
  }
  const bool is_open = first != nullptr && !best;
  // A tank's outflow bends a static curve as well, but less well than its power.
  const bool may_bend = first != nullptr && (best ? best->model.grey_box.has_value() : may_be_curved(*first));
  const auto try_input = [&](const char* what, const auto& trial_of_input) {
    say(what);
    std::optional<Trial> trial = trial_of_input(task, identification, *first);
    if (trial && !is_made_up_for(identification, trial->model)) keep_better(std::move(trial));
  };
  // Friction takes a part of a play's error, and of a limit's, but less well than they do.
  const bool may_be_other = is_open || (best && best->model.grey_box);
  if (may_be_other && may_have_play(task, *first)) try_input("a play", trial_of_play);
  if (may_be_other && may_saturate(*first)) try_input("an input that saturates", trial_of_saturation);
  if (may_bend) try_input("a gain that is curved", trial_of_power);
  if (best && best->explanation.kind != ident::ExplanationKind::structure) {
    for (IdentifiedModel& one : identification.models) one.result.model.provenance.erase(ident::kGreyBoxHolds);
  }
  if (!any && !best) return;
  if (best) {
    note_on_models(*best, identification);
    // An experiment that was chosen for what the models lack is not the next step any more.
    identification.next_experiment.reset();
    std::erase_if(identification.rounds, [](const Round& round) { return round.kind == Round::Kind::experiment; });
  }
  for (IdentifiedModel& one : identification.models) {
    ident::Model& model = one.result.model;
    if (!model.verdict) continue;
    if (!model.provenance.contains(ident::kGreyBoxHolds) && !ident::explanation(model)) continue;
    const auto band = model.verdict->usable_band;
    model.verdict = ident::judge(model, task.acceptance, facts_of(task));
    model.verdict->usable_band = band;
  }
  choose(task, identification);
  if (!best) return;
  // What rounds before had found is not why they were tried any more.
  for (Round& round : identification.rounds) {
    if (!round.reason.empty()) round.reason = identification.recommendation.reason;
  }
}

}  // namespace eha::identify
