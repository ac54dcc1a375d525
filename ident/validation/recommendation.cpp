// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/recommendation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "ident/fractional/poles.hpp"
#include "ident/model/engineering_form.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/explanation.hpp"
#include "ident/validation/slow_pair.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident {
namespace {

using Models = std::vector<const Model*>;

/// Those that can be compared with the first one that has a criterion, the least AR-BIC first.
Models compared(const Models& models) {
  const auto first = std::find_if(models.begin(), models.end(), [](const Model* model) {
    return model->estimation && model->estimation->information && std::isfinite(ar_bic(*model));
  });
  Models kept;
  if (first == models.end()) return kept;
  std::copy_if(models.begin(), models.end(), std::back_inserter(kept),
               [&](const Model* model) { return is_comparable(*model, **first); });
  std::stable_sort(kept.begin(), kept.end(), [](const Model* a, const Model* b) { return ar_bic(*a) < ar_bic(*b); });
  return kept;
}

bool is_accepted(const Model& model) { return model.verdict && model.verdict->accepted; }

/// What is wrong first of all, in half a sentence.
std::string first_reason(const Model& model) {
  return !model.verdict || model.verdict->reasons.empty() ? "it is rejected"
                                                          : statement_of(model.verdict->reasons.front());
}

/// Frequency [Hz] of a pair of poles so far above the band that the record shows that only its lag can be seen there.
std::optional<double> unseen_resonance_Hz(const Model& model) {
  constexpr double kFarAbove = 10.0;  // times the highest usable frequency
  const std::vector<Term>& terms = model.transfer_function.denominator;
  if (!has_whole_orders(terms) || !model.verdict || !model.verdict->usable_band) return std::nullopt;
  const ReducedPolynomial polynomial = reduced(terms);
  if (polynomial.terms.size() < 2) return std::nullopt;  // an integrator has no other pole
  for (const std::complex<double>& pole : commensurate_roots(polynomial, 1.0)) {
    const double f_Hz = std::abs(pole) / (2.0 * std::numbers::pi);
    if (pole.imag() > 1e-7 * std::abs(pole) && f_Hz > kFarAbove * model.verdict->usable_band->highest_Hz) return f_Hz;
  }
  return std::nullopt;
}

/// The statistic of the test for nonlinear effects where it fails: such a plant looks fractional to a linear model.
double bend(const Model& model) {
  if (!model.validation || !model.validation->tests || !model.validation->tests->nonlinearity) return 0.0;
  const ResidualTest& test = model.validation->tests->nonlinearity->test;
  return test.degrees > 0 && test.p < kNonlinearLevel ? test.statistic : 0.0;
}

/// Whether a dead time was estimated that the record does not tell from a lag.
bool has_unseen_delay(const Model& model) {
  return may_be_lag(model) && std::any_of(model.parameters.begin(), model.parameters.end(),
                                          [](const auto& p) { return p.role == ParameterRole::delay && !p.fixed; });
}

/// What a model must gain on those of integer order.
double needed_gain(const Model& model) {
  if (has_estimated_order(model)) return kFractionalGain + bend(model);
  return unseen_resonance_Hz(model) || has_unseen_delay(model) ? kFractionalGain : 0.0;
}

/// What a model with a map must gain on those without one.
double needed_by_map(const Model& model) { return model.input_map ? kMapGain : 0.0; }

/// AR-BIC of a model that has what it must gain taken off.
double handicapped(const Model& model) { return ar_bic(model) + needed_gain(model); }

/// The best of one kind; null without one. @param all  the least AR-BIC first
const Model* best(const Models& all, bool with_estimated_order) {
  const auto found = std::find_if(
      all.begin(), all.end(), [&](const Model* model) { return has_estimated_order(*model) == with_estimated_order; });
  return found == all.end() ? nullptr : *found;
}

/// Whether every estimated order is a whole number for any use; what it gains is then another effect's.
bool is_whole_in_effect(const Model& model) {
  constexpr double kHardlyFractional = 0.01;
  return std::all_of(model.parameters.begin(), model.parameters.end(), [](const ParameterEstimate& p) {
    return !is_order(p.role) || p.fixed || std::abs(p.value - std::round(p.value)) < kHardlyFractional;
  });
}

/// The least AR-BIC first of the models that an estimated order must beat: those of integer order, and those whose
/// estimated orders are whole in effect, which speak for an integer order too. Null: it need not beat any.
const Model* rival_of_orders(const Models& all, const Model& model) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Model* other) {
    return !has_estimated_order(*other) || (!is_whole_in_effect(model) && is_whole_in_effect(*other));
  });
  return found == all.end() ? nullptr : *found;
}

/// Whether a pair of poles that hardly decays lies at or above half the rate of the compared samples: what the input
/// did between the rows makes one, and the record shows no such motion.
bool rings_between_rows(const Model& model) {
  constexpr double kLittleDamping = 0.2;
  constexpr double kNearHalf = 0.9;  // of half the rate
  const std::vector<Term>& terms = model.transfer_function.denominator;
  if (!has_whole_orders(terms) || !model.estimation || !model.estimation->compared_step_s) return false;
  const ReducedPolynomial polynomial = reduced(terms);
  if (polynomial.terms.size() < 2) return false;
  const double least_rad_s = kNearHalf * std::numbers::pi / *model.estimation->compared_step_s;
  const auto poles = commensurate_roots(polynomial, 1.0);
  return std::any_of(poles.begin(), poles.end(), [&](const std::complex<double>& pole) {
    return pole.imag() > least_rad_s && -pole.real() < kLittleDamping * std::abs(pole);
  });
}

bool is_blurred(const Model& model) {
  return model.verdict && fails_any(*model.verdict, {CriterionKind::input_noise, CriterionKind::between_rows});
}

/// Whether noise of the measured input, or its way between the rows, makes what a model without a map and without
/// estimated orders leaves over: a map or an order then takes that in.
bool takes_in_input_error(const Models& all, const Model& model) {
  return (model.input_map || has_estimated_order(model)) && std::any_of(all.begin(), all.end(), [](const Model* other) {
           return is_blurred(*other) && !other->input_map && !has_estimated_order(*other);
         });
}

/// Whether the model is of integer order, or gains enough on every model that speaks for integer orders. One that takes
/// in a drift may not while another one is accepted.
bool may_be_picked(const Models& all, const Model& model) {
  if (takes_in_a_drift(model)) {
    return std::none_of(all.begin(), all.end(),
                        [](const Model* other) { return is_accepted(*other) && !takes_in_a_drift(*other); });
  }
  if (takes_in_input_error(all, model)) return false;
  // What a controller makes of noise bends a map as no valve does.
  if (model.input_map && model.provenance.contains(kLoopOfRecord)) return false;
  if (rings_between_rows(model)) {
    return std::none_of(all.begin(), all.end(),
                        [](const Model* other) { return is_accepted(*other) && !rings_between_rows(*other); });
  }
  if (!has_estimated_order(model)) return true;
  const bool integer_is_accepted = std::any_of(
      all.begin(), all.end(), [](const Model* other) { return !has_estimated_order(*other) && is_accepted(*other); });
  if (is_whole_in_effect(model) && integer_is_accepted) return false;
  const Model* rival = rival_of_orders(all, model);
  return rival == nullptr || handicapped(model) <= ar_bic(*rival);
}

/// The identified models in the order in which they are preferred. One of estimated order that does not gain enough
/// comes last.
Models preferred(const Models& all, Models identified) {
  std::stable_sort(identified.begin(), identified.end(), [&](const Model* a, const Model* b) {
    if (may_be_picked(all, *a) != may_be_picked(all, *b)) return may_be_picked(all, *a);
    return handicapped(*a) + needed_by_map(*a) < handicapped(*b) + needed_by_map(*b);
  });
  return identified;
}

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

/// Whether the difference of AR-BIC is too small to tell.
bool is_unclear_between(const Model& picked, const Model& other) {
  return std::abs(ar_bic(other) - ar_bic(picked)) < kClearGain;
}

bool one_has_a_delay(const Model& picked, const Model& other) {
  return (picked.transfer_function.delay_s > 0.0) != (other.transfer_function.delay_s > 0.0);
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

/// @param all  the least AR-BIC first
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

/// "; cylinder, 2.2 better, has a resonance at 14.6 Hz ..." of those that would else be picked, or as well.
/// @param all  the least AR-BIC first
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

/// "; io_valve, 4.2 better, has a map ..." of the accepted ones that their map kept from being picked.
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

/// "; io, 130.2 better, takes a drift ..." of those that would else be picked.
std::string drifts(const Model& picked, const Models& all) {
  std::string text;
  for (const Model* model : all) {
    const double gain = ar_bic(picked) - ar_bic(*model);
    if (gain <= 0.0 || takes_in_a_drift(picked) || !takes_in_a_drift(*model) || !is_accepted(*model)) continue;
    text += fmt::format("; {}, {:.1f} better, takes a drift of the output for a part of the plant", model->name, gain);
  }
  return text;
}

bool fails_input_test(const Model& model) {
  return model.verdict && fails_any(*model.verdict, {CriterionKind::residual_input});
}

/// @param all  the least AR-BIC first
std::string without_input_in_residual(const Model& picked, const Models& all) {
  const Model* other = explaining(picked, all);
  return other == nullptr
             ? std::string()
             : fmt::format("; of the accepted ones {} leaves nothing over that the tests show the input to move",
                           other->name);
}

/// The word of a rejected model's verdict beside the picked one.
std::string_view word_beside(const Model& picked, const Model& model) {
  if (!model.verdict) return text(Grade::rejected);
  Verdict verdict = *model.verdict;
  verdict.error_over_recommended = error_over(model, picked);
  return verdict_word(verdict);
}

/// Why better models by AR-BIC are not picked: "; io3, 25.1 better, is rejected: a0 = ...". @param all  the least first
/// @param named  already; null for none @param runner_up  of which any lower AR-BIC is explained; null for none
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

/// The first reason of a verdict, with what to do. Precondition: it has reasons.
std::string first_whole_reason(const Model& model) {
  std::string reason = model.verdict->reasons.front();
  if (reason.ends_with('.')) reason.pop_back();
  return reason;
}

/// What lies in the record, and holds for every model of it, with what to do; empty without such a thing.
std::string cause_in_record(const Models& all) {
  const auto has_reason = [](const Model& model) { return model.verdict && !model.verdict->reasons.empty(); };
  for (const Model* model : all) {
    const ErrorCause error = model->verdict ? error_cause(*model, *model->verdict) : ErrorCause::unknown;
    const bool is_of_record = error == ErrorCause::wrong_input || error == ErrorCause::frozen ||
                              error == ErrorCause::slow_rows ||
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
  if (!may_be_picked(all, model)) {
    return is_whole_in_effect(model)
               ? std::string("its estimated orders are whole for any use")
               : std::string("its estimated orders gain too little (AR-BIC) on a model of integer order");
  }
  return "another one errs less than half as much on the unseen part, and may not be recommended itself";
}

std::string accepted_among(const Models& models, const Models& all, const Models& order) {
  std::string text;
  for (const Model* model : models) {
    if (!is_accepted(*model)) continue;
    text += fmt::format("{}{} is {}: {}", text.empty() ? "" : "; ", model->name, verdict_word(*model->verdict),
                        why_not(*model, all, order));
  }
  return text;
}

std::ptrdiff_t estimated_count(const Model& model) {
  return std::count_if(model.parameters.begin(), model.parameters.end(),
                       [](const ParameterEstimate& p) { return !p.fixed; });
}

/// An accepted model with less than half the error on the unseen part, or less than a third where it has more
/// parameters; null without one. What the estimation part gains by more parameters was then overfitted, or is of
/// frequencies that the other part has not; or a noise model took for noise what a part of the plant makes.
const Model* surpassing(const Models& order, const Model& model) {
  constexpr double kHalfOfError = 0.25;  // of a squared one
  constexpr double kThirdOfError = 1.0 / 9.0;
  if (!model.validation) return nullptr;
  const auto found = std::find_if(order.begin(), order.end(), [&](const Model* other) {
    return other != &model && is_accepted(*other) && other->validation && !has_estimated_order(*other) &&
           other->validation->score.mse <
               (estimated_count(*other) <= estimated_count(model) ? kHalfOfError : kThirdOfError) *
                   model.validation->score.mse;
  });
  return found == order.end() ? nullptr : *found;
}

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

/// Why none of the identified models is picked.
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

/// The first of the models that is not the picked one; null without one. One that is far worse tells nothing of the
/// choice: then the least AR-BIC of the others. @param order  as preferred
const Model* next_best(const Models& order, const Model& picked) {
  constexpr double kFarWorse = 50.0;  // of AR-BIC
  const Model* first = nullptr;
  const Model* least = nullptr;
  for (const Model* model : order) {
    if (model == &picked) continue;
    if (first == nullptr) first = model;
    if (least == nullptr || ar_bic(*model) < ar_bic(*least)) least = model;
  }
  return first != nullptr && ar_bic(*first) > ar_bic(picked) + kFarWorse ? least : first;
}

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

/// Of rejected models the one that errs least on unseen data, as their table has it first; of equal ones the best by
/// the criterion.
const Model& nearest(const Models& all) {
  const auto fit_percent = [](const Model* model) {
    return model->validation ? model->validation->score.fit_percent : -std::numeric_limits<double>::infinity();
  };
  return **std::max_element(all.begin(), all.end(),
                            [&](const Model* a, const Model* b) { return fit_percent(a) < fit_percent(b); });
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
