// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/recommendation_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>

#include "ident/model/engineering_form.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/explanation.hpp"
#include "ident/validation/recommendation.hpp"
#include "ident/validation/slow_pair.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident::choice {

std::string first_reason(const Model& model) {
  return !model.verdict || model.verdict->reasons.empty() ? "it is rejected"
                                                          : statement_of(model.verdict->reasons.front());
}

namespace {

/// What kept a model of estimated order from being picked. @param all  the least AR-BIC first
std::string held_back_by(const Models& all, const Model& fractional) {
  std::string text = fmt::format("estimated orders must gain {:g}", kFractionalGain);
  if (const double bent = bend(fractional); bent > 0.0) {
    text += fmt::format(" and, as the plant is not linear, the {:.0f} that its nonlinear effects explain", bent);
  }
  if (is_whole_in_effect(fractional)) return text + fmt::format("; those of {} are whole for any use", fractional.name);
  const Model* rival = rival_of_orders(all, fractional);
  if (rival != nullptr && has_estimated_order(*rival) && ar_bic(fractional) < ar_bic(*rival)) {
    text += fmt::format(" on {}, whose estimated orders are whole for any use", rival->name);
  }
  return text;
}

/// What a small difference of AR-BIC leaves open; empty for a clear one.
std::string unclear_between(const Model& picked, const Model& runner_up) {
  if (!is_unclear_between(picked, runner_up)) return {};
  const bool has_delay = one_has_a_delay(picked, runner_up);
  return fmt::format("; a difference below {:g} is not clear: {}{}", kClearGain,
                     unclear_choice({.model = picked.name, .runner_up = runner_up.name, .is_lag_or_delay = has_delay}),
                     has_delay ? ": take their sum, neither alone" : "");
}

/// Why a model of lower AR-BIC and estimated orders is not taken. @param all  the least AR-BIC first
std::string not_taken(const Model& picked, const Model& fractional, const Models& all) {
  const std::string lower =
      fmt::format("that of {} is {:.1f} lower", fractional.name, ar_bic(picked) - ar_bic(fractional));
  if (is_whole_in_effect(fractional)) {
    return fmt::format(
        "{}, but {} is not taken: its estimated orders are whole for any use, so a model of integer order says the "
        "same",
        lower, fractional.name);
  }
  return fmt::format("{}, but {} is not taken: {}, as orders that are estimated fit other effects too", lower,
                     fractional.name, held_back_by(all, fractional));
}

}  // namespace

std::string reason_for(const Model& picked, const Models& all, const Model* runner_up) {
  if (all.size() == 1) return "it is the only model compared";
  const auto is_lower = [&](const Model& of) { return ar_bic(of) < ar_bic(picked); };
  const Model* other = best(all, !has_estimated_order(picked));
  const bool is_held_back = other != nullptr && !has_estimated_order(picked) && is_lower(*other);
  const bool names_runner_up = runner_up != nullptr && !(is_held_back && runner_up == other);
  std::string text = fmt::format("its AR-BIC of {:.1f} is ", ar_bic(picked));
  if (all.front() == &picked) {
    text += fmt::format("the least of {} models", all.size());
  } else if (names_runner_up && is_lower(*runner_up)) {
    text += "not the least (lower is better)";  // why the lower one is not taken follows
  } else {
    text += "the least of those that may be picked (lower is better)";
  }
  const auto apart = [&](const Model& of) {
    const double difference = std::abs(ar_bic(of) - ar_bic(picked));
    return is_lower(of) ? fmt::format("that of {} is {:.1f} lower", of.name, difference)
                        : fmt::format("{:.1f} below that of {}", difference, of.name);
  };
  if (names_runner_up) text += (is_lower(*runner_up) ? ": " : ", ") + apart(*runner_up);
  const std::string unclear = runner_up == nullptr ? "" : unclear_between(picked, *runner_up);
  if (other == nullptr) return text + unclear;
  if (is_held_back) return text + "; " + not_taken(picked, *other, all) + unclear;
  if (other != runner_up) text += " and " + apart(*other);
  if (has_estimated_order(picked)) {
    text += fmt::format(", and estimated orders must gain {:g} on every model of integer order", kFractionalGain);
  } else {
    text += ", and " + held_back_by(all, *other);
  }
  return text + unclear;
}

std::string unseen_resonances(const Model& picked, const Models& all, const Model* runner_up) {
  std::string text;
  for (const Model* model : all) {
    const auto f_Hz = unseen_resonance_Hz(*model);
    if (!f_Hz || model == &picked || !is_accepted(*model)) continue;
    const double gain = ar_bic(picked) - ar_bic(*model);
    if (gain <= (model == runner_up ? 0.0 : -kClearGain)) continue;
    text += fmt::format(
        "; {}, {:.1f} {}, has a resonance at {:.3g} Hz, far above the band that the record shows, and must gain {:g}",
        model->name, std::abs(gain), gain > 0.0 ? "better" : "worse", *f_Hz, kFractionalGain);
  }
  return text;
}

std::string needless_maps(const Model& picked, const Models& all) {
  std::string text;
  for (const Model* model : all) {
    const double gain = ar_bic(picked) - ar_bic(*model);
    if (picked.input_map || !model->input_map || has_estimated_order(*model) || !is_accepted(*model)) continue;
    if (gain <= 0.0 || gain > kMapGain) continue;
    text += fmt::format("; {}, {:.1f} better, has a map, which must gain {:g}", model->name, gain, kMapGain);
  }
  return text;
}

std::string drifts(const Model& picked, const Models& all) {
  std::string text;
  for (const Model* model : all) {
    const double gain = ar_bic(picked) - ar_bic(*model);
    if (gain <= 0.0 || takes_in_a_drift(picked) || !takes_in_a_drift(*model) || !is_accepted(*model)) continue;
    text += fmt::format("; {}, {:.1f} better, takes a drift of the output for a part of the plant", model->name, gain);
  }
  return text;
}

std::string without_input_in_residual(const Model& picked, const Models& all) {
  const Model* other = explaining(picked, all);
  return other == nullptr
             ? std::string()
             : fmt::format("; of the accepted ones {} leaves nothing over that the tests show the input to move",
                           other->name);
}

namespace {

/// The word of a rejected model's verdict beside the picked one.
std::string_view word_beside(const Model& picked, const Model& model) {
  if (!model.verdict) return text(Grade::rejected);
  Verdict verdict = *model.verdict;
  verdict.error_over_recommended = error_over(model, picked);
  return verdict_word(verdict);
}

}  // namespace

std::string better_but_rejected(const Model& picked, const Models& all, const Model* named, const Model* runner_up) {
  constexpr std::size_t kMostNamed = 3;
  std::string text;
  std::size_t count = 0;
  for (const Model* model : all) {
    const double gain = ar_bic(picked) - ar_bic(*model);
    const double least = model == runner_up ? 0.0 : kFractionalGain;
    if (gain <= 0.0 || gain < least || is_accepted(*model) || model == named) continue;
    if (++count > kMostNamed) continue;
    text += fmt::format("; {}, {:.1f} better, is {}: {}", model->name, gain, word_beside(picked, *model),
                        first_reason(*model));
  }
  if (count > kMostNamed) text += fmt::format("; and {} more, whose verdicts the table has", count - kMostNamed);
  return text;
}

namespace {

/// The first reason of a verdict, with what to do. Precondition: it has reasons.
std::string first_whole_reason(const Model& model) {
  std::string reason = model.verdict->reasons.front();
  if (reason.ends_with('.')) reason.pop_back();
  return reason;
}

}  // namespace

std::string cause_in_record(const Models& all) {
  const auto has_reason = [](const Model& model) { return model.verdict && !model.verdict->reasons.empty(); };
  for (const Model* model : all) {
    const ErrorCause error = model->verdict ? error_cause(*model, *model->verdict) : ErrorCause::unknown;
    const bool is_of_record = error == ErrorCause::wrong_input || error == ErrorCause::moved_rows ||
                              error == ErrorCause::frozen || error == ErrorCause::slow_rows ||
                              (error == ErrorCause::feedback && model->provenance.contains(kLoopOfRecord));
    const bool is_at_stop = model->validation && model->validation->end_stop;
    const bool jumps_far = model->verdict && fails_any(*model->verdict, {CriterionKind::far_jump});
    if (has_reason(*model) && (is_of_record || is_at_stop || jumps_far)) return first_whole_reason(*model);
  }
  const Model& nearest = *all.front();
  if (has_reason(nearest) && explanation_of(nearest, *nearest.verdict)) return first_whole_reason(nearest);
  for (const Model* model : all) {
    if (has_reason(*model) && is_blurred(*model) && !is_accepted(*model)) return first_whole_reason(*model);
  }
  if (has_reason(nearest) && nearest.provenance.contains(kGainChanged)) return first_whole_reason(nearest);
  const bool is_drift = has_reason(nearest) && wanders(nearest, *nearest.verdict) &&
                        error_cause(nearest, *nearest.verdict) == ErrorCause::drift;
  return is_drift ? first_whole_reason(nearest) : std::string();
}

namespace {

/// The word of a model that was not accepted, where none is picked; as in every table.
std::string_view word_of(const Model& model) {
  return model.verdict ? verdict_word(*model.verdict) : text(Grade::rejected);
}

/// Why an accepted model is not recommended where none is. @param all  that are compared, the least AR-BIC first
std::string why_not(const Model& model, const Models& all, const Models& order) {
  if (std::find(all.begin(), all.end(), &model) == all.end()) return "it has no criterion to compare it by";
  if (std::find(order.begin(), order.end(), &model) == order.end()) {
    return "by the part of the record that estimated it alone it is rejected";
  }
  if (takes_in_a_drift(model)) return "it takes a drift for the plant";
  if (rings_between_rows(model)) return "its pair of poles lies at half the rate of the rows, where none shows";
  if (takes_in_input_error(all, model)) return "its map or its orders take in the error of the recorded input";
  if (is_bent_by_loop(all, model)) return "its map may be what the controller in the record makes of noise";
  if (stands_for_dead_time(all, model)) return "its zero does what a dead time does with fewer parameters";
  if (asks_too_much_of_input(all, model)) return "the input determines less than it estimates";
  if (fits_rounding(all, model)) return "a smaller one errs as little beside the sensor's step";
  if (!may_be_picked(all, model)) {
    return is_whole_in_effect(model)
               ? std::string("its estimated orders are whole for any use")
               : std::string("its estimated orders gain too little (AR-BIC) on a model of integer order");
  }
  return "another one errs less than half as much on the unseen part, and may not be recommended itself";
}

}  // namespace

std::string accepted_among(const Models& models, const Models& all, const Models& order) {
  std::string text;
  for (const Model* model : models) {
    if (!is_accepted(*model)) continue;
    text += fmt::format("{}{} is {}: {}", text.empty() ? "" : "; ", model->name, verdict_word(*model->verdict),
                        why_not(*model, all, order));
  }
  return text;
}

namespace {

/// ", and beside the drift the plant is about K = 1.79 V/V, T = 0.492 s"; empty where that is not known.
std::string plant_beside_the_drift(const Model& drifting) {
  std::string form = form_without_slow_pair(drifting);
  // A semicolon ends the part of a reason that the short answer shows.
  for (std::size_t at = form.find(';'); at != std::string::npos; at = form.find(';')) form[at] = ',';
  return form.empty() ? form : ", and beside the drift the plant is about " + form;
}

/// The accepted model that surpasses others by taking in a drift, for which it may not be picked; null without one.
const Model* surpassing_by_a_drift(const Models& order) {
  for (const Model* model : order) {
    const Model* better = is_accepted(*model) ? surpassing(order, *model) : nullptr;
    if (better != nullptr && takes_in_a_drift(*better)) return better;
  }
  return nullptr;
}

}  // namespace

std::string none_picked(const Models& order, const Models& all) {
  const Model& best_identified = *order.front();
  if (!is_accepted(best_identified)) {
    return fmt::format("{}, the best of the identified ones, is {}: {}", best_identified.name, word_of(best_identified),
                       first_reason(best_identified));
  }
  if (const Model* drifting = surpassing_by_a_drift(order)) {
    return fmt::format(
        "the output drifts: {}, which takes that in, errs less than half as much as the others{}; the sensor, the "
        "supply or the temperature may have drifted: check them, and record again",
        drifting->name, plant_beside_the_drift(*drifting));
  }
  if (may_be_picked(all, best_identified)) {
    return fmt::format("{} is accepted, but {}", best_identified.name, why_not(best_identified, all, order));
  }
  const Model* integer = best(all, false);
  if (integer == nullptr)
    return fmt::format("{} is accepted, but {}", best_identified.name, held_back_by(all, best_identified));
  return fmt::format("{} is accepted, but {} of AR-BIC on every model of integer order, and {} is {}: {}",
                     best_identified.name, held_back_by(all, best_identified), integer->name, word_of(*integer),
                     first_reason(*integer));
}

}  // namespace eha::ident::choice
