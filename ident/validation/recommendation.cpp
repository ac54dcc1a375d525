// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/recommendation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "ident/validation/model_choice.hpp"
#include "ident/validation/recommendation_text.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident {
namespace {

using namespace choice;

/// @param first  stands before every other model; null: none does
bool stands_before(const Model& a, const Model& b, const Model* first) {
  constexpr std::array<std::string_view, 6> kOrder{"good", "usable", kOutdone, kNotNeeded, kNotDetermined, "rejected"};
  const auto place = [&](const Model& model) {
    if (&model == first) return -1;
    const std::string_view word = model.verdict ? verdict_word(*model.verdict) : std::string_view();
    return static_cast<int>(std::find(kOrder.begin(), kOrder.end(), word) - kOrder.begin());
  };
  return std::pair(place(a), shown_mse(a)) < std::pair(place(b), shown_mse(b));
}

/// The model that stands first; null: no models.
const Model* leading(const Models& models, const Recommendation& recommendation) {
  const std::string& name = recommendation.model.empty() ? recommendation.runner_up : recommendation.model;
  const auto named = std::find_if(models.begin(), models.end(), [&](const Model* m) { return m->name == name; });
  if (named != models.end()) return *named;
  const Models all = compared(models);
  return !all.empty() && all.size() == models.size() ? &nearest(all) : nullptr;
}

}  // namespace

const Model* explaining(const Model& model, const std::vector<const Model*>& models) {
  if (!fails_input_test(model)) return nullptr;
  const Model* best = nullptr;
  for (const Model* other : models) {
    const bool explains = is_accepted(*other) && !fails_input_test(*other) && other->validation &&
                          other->validation->tests && is_comparable(*other, model) &&
                          error_over(*other, model).value_or(kAsWell + 1.0) <= kAsWell;
    if (explains && (best == nullptr || ar_bic(*other) < ar_bic(*best))) best = other;
  }
  return best;
}

std::optional<EndStop> end_stop_of(const std::vector<const Model*>& models, std::string_view recommended) {
  for (const Model* model : models) {
    if (!recommended.empty() && model->name != recommended) continue;
    if (model->validation && model->validation->end_stop) return model->validation->end_stop;
  }
  return std::nullopt;
}

std::optional<double> error_over(const Model& model, const Model& other) {
  if (!model.validation || !other.validation || !(other.validation->score.mse > 0.0)) return std::nullopt;
  return std::sqrt(model.validation->score.mse / other.validation->score.mse);
}

double ar_bic(const Model& model) { return model.estimation->information->ar_bic; }

bool is_comparable(const Model& model, const Model& with) {
  if (model.procedure != with.procedure) return false;
  for (const Model* one : {&model, &with}) {
    if (!one->estimation || !one->estimation->information || !std::isfinite(ar_bic(*one))) return false;
  }
  const InformationCriteria& a = *model.estimation->information;
  const InformationCriteria& b = *with.estimation->information;
  return a.record == b.record && a.samples == b.samples;
}

bool has_estimated_order(const Model& model) {
  return std::any_of(model.parameters.begin(), model.parameters.end(),
                     [](const ParameterEstimate& p) { return is_order(p.role) && !p.fixed; });
}

Recommendation recommend(const std::vector<const Model*>& models, const AcceptanceLimits& limits,
                         const Unmeasured& unmeasured) {
  const Models all = compared(models);
  Models identified;
  std::copy_if(all.begin(), all.end(), std::back_inserter(identified), [&](const Model* model) {
    Model unvalidated = *model;
    unvalidated.validation.reset();
    return judge(unvalidated, limits, {.unmeasured = unmeasured}).accepted;
  });
  Recommendation result;
  if (all.empty()) {
    result.reason = "no model has a criterion to compare it by";
    result.accepted_instead = accepted_among(models, all, {});
    return result;
  }
  const std::string cause = cause_in_record(all);
  if (identified.empty()) {
    result.reason = !cause.empty() ? cause
                                   : fmt::format("no model passes its checks; {} comes nearest: {}", nearest(all).name,
                                                 first_reason(nearest(all)));
    result.accepted_instead = accepted_among(models, all, {});
    return result;
  }
  const Models order = preferred(all, identified);
  const auto picked = std::find_if(order.begin(), order.end(), [&](const Model* model) {
    return is_accepted(*model) && may_be_picked(all, *model) && surpassing(order, *model) == nullptr;
  });
  if (picked == order.end()) {
    result.reason = cause.empty() ? none_picked(order, all) : cause;
    result.runner_up = order.front()->name;  // which the reason names
    result.accepted_instead = accepted_among(models, all, order);
    return result;
  }
  // A rejected one is held against it where no other is accepted.
  Models accepted;
  std::copy_if(order.begin(), order.end(), std::back_inserter(accepted),
               [](const Model* model) { return is_accepted(*model); });
  const Model* runner_up = next_best(accepted, **picked);
  if (runner_up == nullptr) runner_up = next_best(order, **picked);
  if (runner_up == nullptr) runner_up = next_best(all, **picked);
  result.model = (*picked)->name;
  result.runner_up = runner_up == nullptr ? std::string() : runner_up->name;
  result.reason = reason_for(**picked, all, runner_up);
  if (runner_up != nullptr && is_unclear_between(**picked, *runner_up)) {
    result.is_unclear = true;
    result.is_lag_or_delay = one_has_a_delay(**picked, *runner_up);
  }
  result.validation_chose = picked != order.begin();
  if (result.validation_chose) {
    const Model& first = *order.front();
    const std::string why =
        is_accepted(first) && (*picked)->validation && first.validation && (*picked)->validation->score.mse > 0.0
            ? fmt::format("errs {:.1f} times as much on the unseen part",
                          std::sqrt(first.validation->score.mse / (*picked)->validation->score.mse))
            : "fails validation";
    result.reason += fmt::format(
        "; {}, which the estimation part prefers, {}, so only a fresh record can confirm this choice", first.name, why);
  }
  result.reason += unseen_resonances(**picked, all, runner_up);
  result.reason += needless_maps(**picked, all);
  result.reason += drifts(**picked, all);
  result.reason += without_input_in_residual(**picked, all);
  result.reason += better_but_rejected(**picked, all, result.validation_chose ? order.front() : nullptr, runner_up);
  return result;
}

double shown_mse(const Model& model) {
  const double mse = model.validation   ? model.validation->score.mse
                     : model.estimation ? model.estimation->score.mse
                                        : std::numeric_limits<double>::infinity();
  return std::isnan(mse) ? std::numeric_limits<double>::infinity() : mse;  // of an output that overflowed
}

std::vector<std::size_t> table_order(const Models& models, const Recommendation& recommendation) {
  const Model* first = leading(models, recommendation);
  std::vector<std::size_t> order(models.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return stands_before(*models[a], *models[b], first); });
  return order;
}

std::string unclear_choice(const Recommendation& recommendation) {
  return fmt::format("this record hardly tells {} from {}{}", recommendation.model, recommendation.runner_up,
                     recommendation.is_lag_or_delay ? ", that is, a lag from a dead time" : "");
}

std::string sentence(const Recommendation& recommendation) {
  if (recommendation.model.empty()) {
    const std::string& accepted = recommendation.accepted_instead;
    return fmt::format("No model is recommended: {}{}", recommendation.reason, accepted.empty() ? "" : "; " + accepted);
  }
  const std::string runner_up =
      recommendation.runner_up.empty() ? "" : fmt::format(" (runner-up {})", recommendation.runner_up);
  return fmt::format("Recommended: {}{}: {}.", recommendation.model, runner_up, recommendation.reason);
}

}  // namespace eha::ident
