// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/model_choice.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numbers>

#include "ident/fractional/poles.hpp"
#include "ident/model/engineering_form.hpp"
#include "ident/validation/recommendation.hpp"
#include "ident/validation/slow_pair.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident::choice {
namespace {

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

std::ptrdiff_t estimated_count(const Model& model) {
  return std::count_if(model.parameters.begin(), model.parameters.end(),
                       [](const ParameterEstimate& p) { return !p.fixed; });
}

/// Whether an accepted plain model does nearly as well: no map, no estimated order.
template <typename Suits>
bool has_plain_one(const Models& all, const Model& model, double most_error, const Suits& suits) {
  return std::any_of(all.begin(), all.end(), [&](const Model* other) {
    return other != &model && is_accepted(*other) && !other->input_map && !has_estimated_order(*other) &&
           suits(*other) && error_over(*other, model).value_or(most_error + 1.0) <= most_error;
  });
}

}  // namespace

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

double bend(const Model& model) {
  if (!model.validation || !model.validation->tests || !model.validation->tests->nonlinearity) return 0.0;
  const ResidualTest& test = model.validation->tests->nonlinearity->test;
  return test.degrees > 0 && test.p < kNonlinearLevel ? test.statistic : 0.0;
}

const Model* best(const Models& all, bool with_estimated_order) {
  const auto found = std::find_if(
      all.begin(), all.end(), [&](const Model* model) { return has_estimated_order(*model) == with_estimated_order; });
  return found == all.end() ? nullptr : *found;
}

bool is_whole_in_effect(const Model& model) {
  constexpr double kHardlyFractional = 0.01;
  return std::all_of(model.parameters.begin(), model.parameters.end(), [](const ParameterEstimate& p) {
    return !is_order(p.role) || p.fixed || std::abs(p.value - std::round(p.value)) < kHardlyFractional;
  });
}

const Model* rival_of_orders(const Models& all, const Model& model) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Model* other) {
    return !has_estimated_order(*other) || (!is_whole_in_effect(model) && is_whole_in_effect(*other));
  });
  return found == all.end() ? nullptr : *found;
}

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

bool takes_in_input_error(const Models& all, const Model& model) {
  return (model.input_map || has_estimated_order(model)) && std::any_of(all.begin(), all.end(), [](const Model* other) {
           return is_blurred(*other) && !other->input_map && !has_estimated_order(*other);
         });
}

bool asks_too_much_of_input(const Models& all, const Model& model) {
  const auto asks = [](const Model& one) {
    return one.verdict && fails_any(*one.verdict, {CriterionKind::excitation_order});
  };
  return asks(model) && has_plain_one(all, model, kAsWell, [&](const Model& other) { return !asks(other); });
}

bool fits_rounding(const Models& all, const Model& model) {
  constexpr double kHardlyMore = 1.05;  // of the error
  return rounding_makes_most(model) && has_plain_one(all, model, kHardlyMore, [&](const Model& other) {
           return estimated_count(other) < estimated_count(model);
         });
}

bool is_bent_by_loop(const Models& all, const Model& model) {
  constexpr double kFarMore = 2.0;  // of the error: no bend makes that
  return model.input_map && model.provenance.contains(kLoopOfRecord) &&
         std::any_of(all.begin(), all.end(), [&](const Model* other) {
           return !other->input_map && error_over(*other, model).value_or(0.0) <= kFarMore;
         });
}

bool stands_for_dead_time(const Models& all, const Model& model) {
  constexpr double kHardlyMore = 1.05;  // of the error
  const std::vector<Term>& zeros = model.transfer_function.numerator;
  if (zeros.size() != 2 || !model.verdict || !model.verdict->usable_band) return false;
  const bool is_first = zeros[0].order > zeros[1].order;
  const double b1 = zeros[is_first ? 0 : 1].coefficient;
  const double b0 = zeros[is_first ? 1 : 0].coefficient;
  if (b1 * b0 >= 0.0 || std::abs(b1 / b0) * 2.0 * std::numbers::pi * model.verdict->usable_band->highest_Hz > 1.0) {
    return false;
  }
  return std::any_of(all.begin(), all.end(), [&](const Model* other) {
    return other != &model && is_accepted(*other) && !has_estimated_order(*other) &&
           (!other->input_map || model.input_map) && other->transfer_function.delay_s > 0.0 &&
           estimated_count(*other) <= estimated_count(model) &&
           error_over(*other, model).value_or(kHardlyMore + 1.0) <= kHardlyMore;
  });
}

bool may_be_picked(const Models& all, const Model& model) {
  if (takes_in_a_drift(model)) {
    return std::none_of(all.begin(), all.end(),
                        [](const Model* other) { return is_accepted(*other) && !takes_in_a_drift(*other); });
  }
  if (takes_in_input_error(all, model) || asks_too_much_of_input(all, model) || fits_rounding(all, model)) return false;
  if (is_bent_by_loop(all, model) || stands_for_dead_time(all, model)) return false;
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

Models preferred(const Models& all, Models identified) {
  std::stable_sort(identified.begin(), identified.end(), [&](const Model* a, const Model* b) {
    if (may_be_picked(all, *a) != may_be_picked(all, *b)) return may_be_picked(all, *a);
    return handicapped(*a) + needed_by_map(*a) < handicapped(*b) + needed_by_map(*b);
  });
  return identified;
}

bool is_unclear_between(const Model& picked, const Model& other) {
  return std::abs(ar_bic(other) - ar_bic(picked)) < kClearGain;
}

bool one_has_a_delay(const Model& picked, const Model& other) {
  return (picked.transfer_function.delay_s > 0.0) != (other.transfer_function.delay_s > 0.0);
}

bool fails_input_test(const Model& model) {
  return model.verdict && fails_any(*model.verdict, {CriterionKind::residual_input});
}

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

const Model& nearest(const Models& all) {
  const auto fit_percent = [](const Model* model) {
    return model->validation ? model->validation->score.fit_percent : -std::numeric_limits<double>::infinity();
  };
  return **std::max_element(all.begin(), all.end(),
                            [&](const Model* a, const Model* b) { return fit_percent(a) < fit_percent(b); });
}

}  // namespace eha::ident::choice
