// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/error_cause.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>

#include "ident/grey_box/grey_box_kind.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/slow_pair.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident {
namespace {

using Kind = CriterionKind;

constexpr double kWhiteLevel = 0.01;   // of the test of the residual itself
constexpr double kMostlyOffset = 0.5;  // of the mean squared error, without its offset

bool passes(const Verdict& verdict, Kind kind) {
  return std::any_of(verdict.criteria.begin(), verdict.criteria.end(),
                     [&](const Criterion& c) { return c.kind == kind && c.judged && c.passed; });
}

/// Whether a model does not follow its record, in anything that its error shows.
bool is_off(const Model& model, const Verdict& verdict) {
  return (model.validation && (model.validation->end_stop || model.validation->jump)) ||
         model.provenance.contains(kGainChanged) ||
         fails_any(verdict, {Kind::r2, Kind::max_abs_error, Kind::residual_input, Kind::residual_whiteness,
                             Kind::nonlinearity, Kind::future_input, Kind::predicted_error, Kind::residual_drift,
                             Kind::saturated, Kind::far_saturated, Kind::error_over_noise, Kind::far_error_over_noise});
}

}  // namespace

std::optional<NonlinearKind> nonlinear_kind(const Model& model, const Verdict& verdict) {
  if (!fails_any(verdict, {Kind::nonlinearity}) || !model.validation || !model.validation->tests) return std::nullopt;
  const auto& test = model.validation->tests->nonlinearity;
  return test ? std::optional(test->kind) : std::nullopt;
}

const GreyBoxKind* grey_box_to_try(const Model& model, const Verdict& verdict) {
  // An integrator that takes in a drift is none of the plant's.
  if (takes_in_a_drift(verdict) || model.grey_box || !model.stability) return nullptr;
  const bool integrates = model.stability->integrator_order > 0.0;
  const std::optional<NonlinearKind> kind = nonlinear_kind(model, verdict);
  if (!integrates) return kind == NonlinearKind::position ? &outflow_kind() : nullptr;
  // A map takes friction for a dead band, whose edges it bends.
  return kind == NonlinearKind::motion || noted_shift(model) ? &friction_kind() : nullptr;
}

const GreyBoxKind* grey_box_left_to_try(const Model& model, const Verdict& verdict) {
  if (takes_in_a_drift(verdict) || model.grey_box || !model.stability) return nullptr;
  const ErrorCause cause = error_cause(model, verdict);
  if (cause != ErrorCause::missing_part && cause != ErrorCause::nonlinear && cause != ErrorCause::drift &&
      cause != ErrorCause::unknown) {
    return nullptr;
  }
  const bool misses = fails_any(verdict, {Kind::r2, Kind::residual_input, Kind::nonlinearity, Kind::error_over_noise,
                                          Kind::far_error_over_noise});
  if (!misses) return nullptr;
  return model.stability->integrator_order > 0.0 ? &friction_kind() : &outflow_kind();
}

const GreyBoxKind* grey_box_to_advise(const Model& model, const Verdict& verdict) {
  if (!model.provenance.contains(kGreyBoxHolds)) return nullptr;
  const GreyBoxKind* kind = grey_box_to_try(model, verdict);
  return kind != nullptr ? kind : grey_box_left_to_try(model, verdict);
}

bool is_rather_nonlinear(const Model& model, const Verdict& verdict) {
  if (!nonlinear_kind(model, verdict)) return false;
  const ResidualTest& nonlinear = model.validation->tests->nonlinearity->test;
  const ResidualTest& linear = model.validation->tests->input;
  const auto strength = [](const ResidualTest& test) {
    return test.statistic / static_cast<double>(std::max<std::size_t>(test.degrees, 1));
  };
  // Of far tails both probabilities are 0.
  if (nonlinear.p > 0.0 || linear.p > 0.0) return nonlinear.p <= linear.p;
  return strength(nonlinear) >= strength(linear);
}

bool wanders(const Model& model, const Verdict& verdict) {
  if (!model.validation || !model.validation->faster_r2_percent) return false;
  const double faster = *model.validation->faster_r2_percent;
  return std::any_of(verdict.criteria.begin(), verdict.criteria.end(),
                     [&](const Criterion& c) { return c.kind == Kind::r2 && has_failed(c) && faster >= c.limit; });
}

ErrorCause error_cause(const Model& model, const Verdict& verdict) {
  if (model.provenance.contains(kWrongInput)) return ErrorCause::wrong_input;
  if (model.provenance.contains(kAsSampled) && is_off(model, verdict)) return ErrorCause::moved_rows;
  if (model.provenance.contains(kFrozenOfRecord) && is_off(model, verdict)) return ErrorCause::frozen;
  const bool is_in_loop = model.provenance.contains(kLoopOfRecord);
  if (!model.validation) return is_in_loop ? ErrorCause::feedback : ErrorCause::unknown;
  if (model.provenance.contains(kSlowRows) && is_off(model, verdict)) return ErrorCause::slow_rows;
  if (is_in_loop) return ErrorCause::feedback;
  if (model.validation->end_stop || fails_any(verdict, {Kind::saturated, Kind::far_saturated})) {
    return ErrorCause::end_stop;
  }
  if (model.validation->jump || model.provenance.contains(kGainChanged)) return ErrorCause::jump;
  if (fails_any(verdict, {Kind::error_over_refit})) return ErrorCause::other_plant;
  if (fails_any(verdict, {Kind::input_noise})) return ErrorCause::input_noise;
  if (fails_any(verdict, {Kind::residual_input, Kind::error_over_noise, Kind::far_error_over_noise})) {
    return ErrorCause::missing_part;
  }
  if (fails_any(verdict, {Kind::nonlinearity})) return ErrorCause::nonlinear;
  if (fails_any(verdict, {Kind::future_input})) return ErrorCause::feedback;
  if (fails_any(verdict, {Kind::residual_drift}) || wanders(model, verdict)) return ErrorCause::drift;
  const std::optional<Score>& anew = model.validation->offset_reestimated;
  const bool is_offset = anew && anew->mse < kMostlyOffset * model.validation->score.mse;
  const bool is_white = !is_offset && passes(verdict, Kind::residual_input) &&
                        passes(verdict, Kind::residual_whiteness) && model.validation->ljung_box_p >= kWhiteLevel;
  return is_white ? ErrorCause::white_noise : ErrorCause::unknown;
}

}  // namespace eha::ident
