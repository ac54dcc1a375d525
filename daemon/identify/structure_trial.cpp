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

#include "core/error.hpp"
#include "core/time_text.hpp"
#include "daemon/identify/judging.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/estimation/prepared_record.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/record.hpp"
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

constexpr double kClearlyLess = 0.9;                  // of an error on unseen data
constexpr double kFarLess = 0.5;                      // the same, of a structure that explains what others leave over
constexpr double kOtherPart = 4.0;                    // times an error, what the two parts may differ by
constexpr double kMostWithoutMap = 0.25;              // of the least error without a map, of one behind it
constexpr Eigen::Index kMostSimulatedRows = 200'000;  // a grey box simulates each of them some 500 times
constexpr std::array kMoreDegrees{ident::Degrees{3, 2}, ident::Degrees{4, 2}, ident::Degrees{4, 3}};
constexpr std::array kMoreBesideIntegrator{ident::Degrees{3, 2}, ident::Degrees{4, 2}, ident::Degrees{5, 2}};
constexpr double kClosest = 0.02;                          // of a gap between levels of the input
constexpr std::array kClipped{0.03, 0.1, 0.2, 0.35, 0.5};  // shares of the rows whose input lies beyond a limit

/// A structure beside those of the table that holds.
struct Trial {
  ident::Model model;
  std::string has;      ///< "dry friction"
  std::string options;  ///< of `eha fit`: "--model friction"
};

/// How a structure beside the table's is fitted.
struct Manner {
  ident::Search search;
  const std::vector<ident::Model>& known;
  std::optional<double> most_mse = {};  ///< as of ident::FitOptions
};

/// The structure fitted to the record as `eha fit --model` does; none where it does not hold.
/// @param prepared  the task's record
std::optional<ident::Model> fit_that_holds(const IdentificationTask& task, const ident::PreparedRecord& prepared,
                                           const ident::StructureOptions& asked, const Manner& manner) {
  ident::FitOptions options = task.options;
  options.search = manner.search;
  options.intervals = ident::IntervalMethod::straight;
  options.most_mse = manner.most_mse;
  try {
    ident::FitResult result = ident::fit(prepared, asked, options, thread_executor(), manner.known);
    judge(task, std::nullopt, result);
    return result.model.verdict->accepted ? std::optional(std::move(result.model)) : std::nullopt;
  } catch (const Error&) {  // the record does not allow it
    return std::nullopt;
  }
}

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
  return Trial{std::move(*model), std::string(kind.effect), fmt::format("--model {}", kind.name)};
}

/// Whether a residual test finds a part of the plant in what a model leaves over.
bool misses_a_part(const ident::Verdict& verdict) {
  return ident::fails_any(
      verdict, {Kind::residual_input, Kind::nonlinearity, Kind::error_over_noise, Kind::far_error_over_noise});
}

constexpr double kLeastDamping = 0.005;

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
    std::optional<ident::Model> model = fit_that_holds(task, prepared, asked, {ident::Search::known, known});
    // Play and friction make a pair of poles that hardly dies away of a plant without one; oil and mass damp more.
    if (!model || ident::least_damping(*model) < kLeastDamping) continue;
    const bool is_clean = !misses_a_part(*model->verdict);
    if (!is_clean && best && !(ident::shown_mse(*model) < ident::shown_mse(best->model))) continue;
    best = Trial{std::move(*model), fmt::format("{} poles and {} zeros", degrees.poles, degrees.zeros),
                 fmt::format("--model io --poles {} --zeros {}{}{}", degrees.poles, degrees.zeros,
                             has_delay ? " --delay free" : "", integrates ? " --fix a0=0" : "")};
    if (is_clean) break;
  }
  return best;
}

/// Whether a trial explains what a model leaves over.
bool explains(const ident::Model& trial, const ident::Model& model) {
  const std::optional<double> over = ident::error_over(trial, model);
  return over && (*over <= kFarLess || (*over <= kClearlyLess && !misses_a_part(*trial.verdict)));
}

/// The input between limits of one size about its mid-range.
Eigen::VectorXd clipped(const Eigen::VectorXd& input, double middle, double limit) {
  return (input.array() - middle).cwiseMax(-limit).cwiseMin(limit) + middle;
}

/// "--from 12.5 --to 48.2": the longest part of a record whose input stays between limits of one size about its
/// mid-range, if that is a fifth of the record and long enough for a fit; empty otherwise.
/// @param parts  rows of the record for one of the file's
std::string part_within(const ident::Record& record, double middle, double limit, Eigen::Index parts) {
  constexpr double kLongEnough = 0.2;
  constexpr Eigen::Index kFewestRows = 300;
  Eigen::Index first = 0;
  Eigen::Index longest = 0;
  for (Eigen::Index k = 0, begun = 0; k < record.input.size(); ++k) {
    if (!(std::abs(record.input[k] - middle) <= limit)) begun = k + 1;
    if (k + 1 - begun > longest) {
      longest = k + 1 - begun;
      first = begun;
    }
  }
  const Eigen::Index rows = record.input.size();
  if (longest < kFewestRows * parts || static_cast<double>(longest) < kLongEnough * static_cast<double>(rows))
    return {};
  const auto time_of = [&](Eigen::Index row) {
    return time_text(record.start_s + static_cast<double>(row) * record.step_s);
  };
  std::string options = first > 0 ? "--from " + time_of(first) : "";
  if (first + longest < rows) options += (options.empty() ? "--to " : " --to ") + time_of(first + longest - 1);
  return options;
}

/// The sizes of an input nearest to a limit.
struct InputGap {
  double lower = 0.0;
  double upper = 0.0;
  bool is_wide = false;  ///< the input has few levels: it has nothing near the limit
};

/// @param sizes  rising
InputGap gap_around(const std::vector<double>& sizes, double limit) {
  constexpr double kSame = 1e-3;  // of the greatest: noise of a measured level
  constexpr double kWide = 0.1;   // of it
  const double same = kSame * sizes.back();
  const auto below = std::lower_bound(sizes.begin(), sizes.end(), limit - same);
  const auto above = std::upper_bound(sizes.begin(), sizes.end(), limit + same);
  InputGap gap{below == sizes.begin() ? 0.0 : *(below - 1), above == sizes.end() ? sizes.back() : *above};
  gap.is_wide = gap.upper - gap.lower > kWide * sizes.back();
  return gap;
}

/// The structures that may describe a plant behind an input that saturates: that of an accepted first model, else the
/// simple ones of the table.
std::vector<const IdentifiedModel*> behind_a_limit(const Identification& identification, const ident::Model& first) {
  constexpr std::array<std::string_view, 3> kSimple{"integrator_lag", "io1", "io"};
  std::vector<const IdentifiedModel*> found;
  for (const IdentifiedModel& one : identification.models) {
    const bool is_first = &one.result.model == &first;
    const bool is_simple = std::find(kSimple.begin(), kSimple.end(), one.structure.name) != kSimple.end();
    if (first.verdict->accepted && !first.input_map ? is_first : is_simple) found.push_back(&one);
  }
  return found;
}

/// The model of a plant whose input saturates: the structure that errs least with the input between limits, at those
/// of kClipped that fit best and then between their neighbours. None that holds.
std::optional<Trial> trial_of_saturation(const IdentificationTask& task, const Identification& identification,
                                         const ident::Model& first) {
  const Eigen::VectorXd& input = task.record.input;
  const bool is_two_sided = input.minCoeff() < 0.0 && input.maxCoeff() > 0.0;
  const double middle = is_two_sided ? 0.0 : 0.5 * (input.minCoeff() + input.maxCoeff());
  std::vector<double> sizes(static_cast<std::size_t>(input.size()));
  for (std::size_t k = 0; k < sizes.size(); ++k) sizes[k] = std::abs(input[static_cast<Eigen::Index>(k)] - middle);
  std::sort(sizes.begin(), sizes.end());
  const auto limit_at = [&](double share) {
    const auto at = static_cast<std::size_t>((1.0 - share) * static_cast<double>(sizes.size() - 1));
    return sizes[at];
  };
  std::vector<const IdentifiedModel*> bases = behind_a_limit(identification, first);
  const IdentifiedModel* base_of_last = nullptr;
  const IdentifiedModel* best_base = nullptr;
  const auto fitted = [&](double limit) {
    ident::Record record = task.record;
    record.input = clipped(input, middle, limit);
    const IdentificationTask cut = with_record(task, record);
    const ident::PreparedRecord prepared(record, task.options);
    std::optional<ident::Model> best;
    for (const IdentifiedModel* base : bases) {
      std::optional<ident::Model> model =
          fit_that_holds(cut, prepared, base->structure, {ident::Search::nearest, {base->result.model}});
      if (!model || (best && !(ident::shown_mse(*model) < ident::shown_mse(*best)))) continue;
      best = std::move(model);
      base_of_last = base;
    }
    return best;
  };
  std::optional<ident::Model> best;
  double best_share = 0.0;
  double best_limit = 0.0;
  const auto take_limit = [&](double limit) {
    std::optional<ident::Model> model = fitted(limit);
    if (!model || (best && !(ident::shown_mse(*model) < ident::shown_mse(*best)))) return false;
    best = std::move(model);
    best_limit = limit;
    best_base = base_of_last;
    return true;
  };
  const auto take = [&](double share) {
    if (take_limit(limit_at(share))) best_share = share;
  };
  for (const double share : kClipped) {
    if (limit_at(share) < sizes.back()) take(share);
  }
  const std::optional<double> over = best ? ident::error_over(*best, best_base->result.model) : std::nullopt;
  if (!over || *over > kClearlyLess) return std::nullopt;
  bases = {best_base};
  for (const double factor : {1.7, 1.3, 1.1}) {
    const double found = best_share;
    take(found / factor);
    take(std::min(0.9, factor * found));
  }
  // Of an input of few levels the limit lies between two of them.
  const InputGap beside = gap_around(sizes, best_limit);
  if (beside.is_wide) {
    for (double step = 0.5; step > kClosest; step *= 0.5) {
      const double found = best_limit;
      take_limit(found - step * (found - beside.lower));
      take_limit(found + step * (beside.upper - found));
    }
  }
  const InputGap gap = gap_around(sizes, best_limit);
  const std::string unit = ident::after_number(task.record.input_channel.unit);
  const double limit = best_limit;
  const std::string between =
      beside.is_wide && is_two_sided
          ? fmt::format(" (between its levels of {:.3g} and {:.3g}{})", gap.lower, gap.upper, unit)
          : std::string();
  return Trial{std::move(*best),
               is_two_sided ? fmt::format("+-{:.2g}{}{}", limit, unit, between)
                            : fmt::format("{:.2g} and {:.2g}{}", middle - limit, middle + limit, unit),
               part_within(task.record, middle, limit, task.record.parts)};
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

/// The mean square error of the estimating part that a trial may have at most and still err clearly less than the model
/// on the other part, however the two parts differ.
double useful_mse(const ident::Model& model) {
  constexpr double kMost = kOtherPart * kClearlyLess;
  const double estimating = model.estimation ? model.estimation->score.mse : 0.0;
  return kMost * kMost * std::max(estimating, ident::shown_mse(model));
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

/// Whether a limit of the input may be what the first model misses: its gain falls as the input grows, or it follows
/// so little that no test tells.
bool may_saturate(const ident::Model& first) {
  if (first.grey_box || !first.validation || !first.validation->tests) return false;
  if (first.validation->end_stop) return false;
  const auto& effect = first.validation->tests->nonlinearity;
  const bool falls = effect && ident::nonlinear_kind(first, *first.verdict) == ident::NonlinearKind::level &&
                     effect->gain == ident::GainTrend::falls;
  // An error that jumps is a sensor's, unless the gain says otherwise: behind a rod that integrates each motion that is
  // cut short by a limit leaves a step.
  return falls || (!first.validation->jump && !first.verdict->accepted && wants_more_poles(first));
}

/// Notes that the trial explains what the models leave over, where it errs clearly less than they do.
void note_on_models(const Trial& trial, Identification& identification) {
  const ident::ValidationReport& seen = *trial.model.validation;
  for (IdentifiedModel& one : identification.models) {
    ident::Model& model = one.result.model;
    const std::optional<double> over = ident::error_over(trial.model, model);
    if (!over || *over > kClearlyLess) continue;
    ident::note_explanation(model, {trial.has, trial.options, ident::figure_text(*over)});
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
  if (!task.slow_rows.empty() || !task.loop.empty()) return;
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
  const double trials = static_cast<double>(kinds.size()) + 2.0;  // more poles, and a limit of the input
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
  if (first != nullptr && !best && may_saturate(*first)) {
    say("an input that saturates");
    std::optional<Trial> trial = trial_of_saturation(task, identification, *first);
    if (trial && !is_made_up_for(identification, trial->model)) keep_better(std::move(trial));
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
