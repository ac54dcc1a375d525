// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/grey_box_trial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "daemon/identify/judging.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/structure/structures.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/recommendation.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::identify {
namespace {

constexpr double kClearlyLess = 0.9;                  // of an error on unseen data
constexpr Eigen::Index kMostSimulatedRows = 200'000;  // such a fit simulates each of them some 500 times

/// The kind fitted to the record as `eha fit --model` does; none where it does not hold.
std::optional<ident::Model> fit_that_holds(const IdentificationTask& task, const ident::GreyBoxKind& kind) {
  ident::StructureOptions asked;
  asked.name = std::string(kind.name);
  asked.structure = ident::structures::grey_box(kind);
  ident::FitOptions options = task.options;
  options.intervals = ident::IntervalMethod::straight;
  try {
    ident::FitResult result = ident::fit(task.record, asked, options, thread_executor());
    judge(task, std::nullopt, result);
    return result.model.verdict->accepted ? std::optional(std::move(result.model)) : std::nullopt;
  } catch (const Error&) {  // the record does not allow it
    return std::nullopt;
  }
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

/// Whether an accepted model errs as little as a grey box, so that it makes up for it.
bool is_made_up_for(const Identification& identification, const ident::Model& box) {
  return std::any_of(identification.models.begin(), identification.models.end(), [&](const IdentifiedModel& one) {
    const std::optional<double> over = ident::error_over(box, one.result.model);
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

}  // namespace

void try_grey_boxes(const IdentificationTask& task, Identification& identification) {
  if (task.options.procedure == ident::Procedure::paper || task.record.input.size() > kMostSimulatedRows) return;
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
  bool any = false;
  for (const ident::GreyBoxKind* kind : kinds) {
    const std::optional<ident::Model> box = fit_that_holds(task, *kind);
    if (!box) continue;
    const bool helps_first = kind == left && (is_asked || !is_made_up_for(identification, *box));
    for (IdentifiedModel& one : identification.models) {
      ident::Model& model = one.result.model;
      const bool is_first = &model == first && helps_first;
      if (!model.verdict || (!is_first && ident::grey_box_to_try(model, *model.verdict) != kind)) continue;
      const std::optional<double> over = ident::error_over(*box, model);
      if (!over || *over > kClearlyLess) continue;
      model.provenance[ident::kGreyBoxHolds] = fmt::format("errs {} times as much", ident::figure_text(*over));
      any = true;
    }
  }
  if (!any) return;
  for (IdentifiedModel& one : identification.models) {
    ident::Model& model = one.result.model;
    if (!model.verdict || !model.provenance.contains(ident::kGreyBoxHolds)) continue;
    const auto band = model.verdict->usable_band;
    model.verdict = ident::judge(model, task.acceptance, facts_of(task));
    model.verdict->usable_band = band;
  }
  choose(task, identification);
}

}  // namespace eha::identify
