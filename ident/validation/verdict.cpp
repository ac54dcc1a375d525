// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/non_central_chi_squared.hpp>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <string_view>
#include <utility>

#include "ident/fractional/stability.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/search/least_squares.hpp"

namespace eha::ident {
namespace {

constexpr double kResidualLevel = 0.01;       // of each residual test
constexpr double kGreatestOrderError = 0.15;  // standard error of a free order
constexpr double kLeastRise = 10.0;           // of AR-BIC, without an order's term
constexpr double kMostExtrapolated_percent = 5.0;
constexpr double kMostSaturated_percent = 1.0;
constexpr double kNoticedShare = 0.1;  // of the residual's power that past input makes, which its test has to notice
constexpr double kNoticedChance = 0.5;

/// What a failed criterion does to the grade.
enum class Weight { rejects, lowers };

class Judgement {
 public:
  /// @param sentence  says why, when it fails
  void criterion(std::string name, double value, double limit, bool passed, Weight weight,
                 const std::string& sentence) {
    criteria_.push_back({std::move(name), value, limit, passed});
    if (passed) return;
    if (weight == Weight::rejects) {
      reject(sentence);
    } else {
      grade_ = std::min(grade_, Grade::usable);
      note(sentence);
    }
  }
  /// For criteria that the record holds too little for. @param sentence  says what is missing
  void not_judged(std::initializer_list<Criterion> criteria, const std::string& sentence) {
    for (Criterion criterion : criteria) {
      criterion.judged = criterion.passed = false;
      criteria_.push_back(std::move(criterion));
    }
    grade_ = std::min(grade_, Grade::usable);
    note(sentence);
  }
  void reject(std::string_view reason) {
    grade_ = Grade::rejected;
    rejections_.emplace_back(reason);
  }
  void note(std::string_view text) { notes_.emplace_back(text); }

  /// Reasons for a rejection first, then notes.
  Verdict verdict() {
    Verdict result{grade_ != Grade::rejected, std::move(rejections_), grade_, std::move(criteria_)};
    result.reasons.insert(result.reasons.end(), notes_.begin(), notes_.end());
    return result;
  }

 private:
  Grade grade_ = Grade::good;
  std::vector<Criterion> criteria_;
  std::vector<std::string> rejections_;
  std::vector<std::string> notes_;
};

void judge_score(const Score& score, const char* part, const Model& model, const AcceptanceLimits& limits,
                 Judgement& judgement) {
  judgement.criterion(fmt::format("{}_r2_percent", part), score.r2_percent, limits.min_validation_r2_percent,
                      score.r2_percent >= limits.min_validation_r2_percent, Weight::rejects,
                      fmt::format("The {} R2 of {:.4g} % is below the limit of {:.4g} %.", part, score.r2_percent,
                                  limits.min_validation_r2_percent));
  const double least = std::abs(score.error_min);
  const double greatest = std::abs(score.error_max);
  const double error =
      std::isnan(greatest) ? greatest : std::max(least, greatest);  // max() would drop a NaN on its right
  // Without a limit (infinity) only a NaN fails here.
  judgement.criterion(fmt::format("{}_max_abs_error", part), error, limits.max_abs_error, error <= limits.max_abs_error,
                      Weight::rejects,
                      fmt::format("The greatest {} error of {:.4g} {} is above the limit of {:.4g} {}.", part, error,
                                  model.output_unit, limits.max_abs_error, model.output_unit));
}

double lowest_order(const std::vector<Term>& terms) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Term& term : terms) {
    if (term.coefficient != 0.0) lowest = std::min(lowest, term.order);
  }
  return lowest;
}

/// Whether the model would be stable without its poles at 0.
bool only_integrates(const TransferFunction& g) {
  const double poles = lowest_order(g.denominator);
  if (!(poles > lowest_order(g.numerator)) || std::isinf(poles)) return false;
  TransferFunction rest = g;
  for (Term& term : rest.denominator) term.order = std::max(0.0, term.order - poles);
  return stability(rest).stable;
}

void judge_stability(const Model& model, const AcceptanceLimits& limits, Judgement& judgement) {
  if (!model.stability) {
    if (limits.require_stable) judgement.reject("The model's stability was not determined, and the limits require it.");
    return;
  }
  const StabilityReport& stability = *model.stability;
  const bool forbidden = limits.require_stable && !stability.stable;
  const bool too_near = stability.stable && !(stability.margin_rad >= limits.min_stability_margin_rad);
  std::string sentence = fmt::format("The stability margin of {:.4g} rad is below the limit of {:.4g} rad.",
                                     stability.margin_rad, limits.min_stability_margin_rad);
  if (forbidden && only_integrates(model.transfer_function)) {
    sentence =
        "The model integrates, and the limits require a stable one; [acceptance] require_stable = false of an "
        "experiment file allows it.";
  } else if (forbidden) {
    sentence = fmt::format("The model is unstable (test: {}, margin {:.4g} rad), and the limits require a stable one.",
                           stability.test, stability.margin_rad);
  } else if (!stability.stable) {
    judgement.note(fmt::format("The model is unstable (test: {}, margin {:.4g} rad); the limits allow it.",
                               stability.test, stability.margin_rad));
  }
  judgement.criterion("stability_margin_rad", stability.margin_rad, limits.min_stability_margin_rad,
                      !forbidden && !too_near, Weight::rejects, sentence);
}

/// Whether a residual correlates with the input that follows, and with that more than with what went before.
bool leads(const Correlation& ccf) {
  double future = 0.0;
  double past = 0.0;
  for (std::size_t i = 0; i < std::min(ccf.lags.size(), ccf.values.size()); ++i) {
    double& side = ccf.lags[i] < 0 ? future : past;
    side = std::max(side, std::abs(ccf.values[i]));
  }
  return future > ccf.bound99 && future > past;
}

/// Whether the test of the residual with past input would notice that the input makes kNoticedShare of the residual, at
/// least with kNoticedChance: the power of a chi-squared test.
bool can_notice(const ResidualTest& input, std::size_t samples) {
  if (input.degrees == 0) return false;
  const auto degrees = static_cast<double>(input.degrees);
  const double limit =
      boost::math::quantile(boost::math::complement(boost::math::chi_squared(degrees), kResidualLevel));
  const double noncentrality = static_cast<double>(samples) * kNoticedShare / (1.0 - kNoticedShare);
  const boost::math::non_central_chi_squared missing(degrees, noncentrality);
  return boost::math::cdf(boost::math::complement(missing, limit)) >= kNoticedChance;
}

/// Whether the residual holds a part of the plant, and is noise.
void judge_tests(const ValidationReport& validation, Judgement& judgement) {
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  const std::size_t samples = validation.score.samples;
  if (!validation.tests) {
    judgement.not_judged({{"residual_input_p", unknown, kResidualLevel},
                          {"residual_whiteness_p", unknown, kResidualLevel},
                          {"residual_drift", unknown, unknown}},
                         fmt::format("Not judged whether the model misses a part of the plant: {} validating samples "
                                     "are too few for the residual's tests; record longer.",
                                     samples));
    return;
  }
  const ResidualTest& input = validation.tests->input;
  if (input.p >= kResidualLevel && !can_notice(input, samples)) {
    judgement.not_judged(
        {{"residual_input_p", input.p, kResidualLevel}},
        fmt::format(
            "Not judged whether the model misses a part of the plant: with {} validating samples the test would more "
            "likely miss than detect one that makes {:.0f} % of the residual's power; record longer.",
            samples, 100.0 * kNoticedShare));
  } else {
    judgement.criterion("residual_input_p", input.p, kResidualLevel, input.p >= kResidualLevel, Weight::lowers,
                        fmt::format("The residual correlates with past input (p = {:.2g} for lags 0 to 20 together): "
                                    "the model may miss a part of the plant.",
                                    input.p));
  }
  const ResidualTest& whiteness = validation.tests->whiteness;
  judgement.criterion("residual_whiteness_p", whiteness.p, kResidualLevel, whiteness.p >= kResidualLevel,
                      Weight::lowers,
                      fmt::format("The residual is no autoregressive noise of order {} (p = {:.2g} for lags 1 to 20 "
                                  "together).",
                                  validation.tests->ar_order, whiteness.p));
  if (!validation.tests->drift) return;
  const ResidualDrift& drift = *validation.tests->drift;
  judgement.criterion("residual_drift", drift.change, drift.expected, drift.change <= drift.expected, Weight::lowers,
                      fmt::format("The residual drifts by {:.3g} over the validation part, more than the {:.3g} that "
                                  "noise and the parameters' errors explain: the sensor or an offset drifts.",
                                  drift.change, drift.expected));
}

void judge_residual(const ValidationReport& validation, const AcceptanceLimits& limits, Judgement& judgement) {
  judge_tests(validation, judgement);
  if (validation.saturated_percent) {
    const double share = *validation.saturated_percent;
    judgement.criterion("saturated_percent", share, kMostSaturated_percent, share <= kMostSaturated_percent,
                        Weight::lowers,
                        fmt::format("The output stays at its greatest or least value for {:.3g} % of the samples while "
                                    "the model goes on, more than {:.3g} %: sensor or actuator saturate.",
                                    share, kMostSaturated_percent));
  }
  if (validation.extrapolated_percent) {
    const double share = *validation.extrapolated_percent;
    judgement.criterion("extrapolated_percent", share, kMostExtrapolated_percent, share <= kMostExtrapolated_percent,
                        Weight::lowers,
                        fmt::format("{:.3g} % of the validating samples have an input outside the range that the "
                                    "model was estimated on, more than {:.3g} %.",
                                    share, kMostExtrapolated_percent));
  }
  if (validation.score.r2_percent < limits.min_validation_r2_percent && leads(validation.ccf)) {
    judgement.note(
        "The residual correlates with future input more than with past input: input and output may be exchanged, or a "
        "controller closes the loop.");
  }
  if (validation.score.r2_percent < limits.min_validation_r2_percent && validation.offset_reestimated) {
    const double anew = validation.offset_reestimated->r2_percent;
    judgement.note(fmt::format(
        "With the offset estimated anew on the validation part R2 is {:.4g} %{}.", anew,
        anew >= limits.min_validation_r2_percent ? ": the sensor or an offset drifts between the two parts" : ""));
  }
}

/// Compares the residual with the noise that the record's own repetitions show.
void judge_noise(const Model& model, double noise_std, Judgement& judgement) {
  const double error = std::sqrt(model.validation->score.mse);
  const double ratio = error / noise_std;
  judgement.criterion(
      "error_over_noise", ratio, kGreatestErrorOverNoise, ratio <= kGreatestErrorOverNoise, Weight::lowers,
      fmt::format("The validation error of {:.3g} {} (rms) is {:.3g} times the noise of {:.3g} {} that differs between "
                  "the record's periods, more than {:.3g}: the model misses a part of the plant.",
                  error, model.output_unit, ratio, noise_std, model.output_unit, kGreatestErrorOverNoise));
}

void judge_order(const ParameterEstimate& p, const std::vector<LeftOut>& left_out, Judgement& judgement) {
  judgement.criterion("std_" + p.name, p.std, kGreatestOrderError, p.std <= kGreatestOrderError, Weight::rejects,
                      fmt::format("{} = {}: its standard error of {:.2g} exceeds {}.", p.name, with_interval(p), p.std,
                                  kGreatestOrderError));
  for (const LeftOut& entry : left_out) {
    if (entry.order != p.name) continue;
    judgement.criterion("left_out_" + p.name, entry.rise, kLeastRise, entry.rise >= kLeastRise, Weight::rejects,
                        fmt::format("{} = {}: leaving its term out costs {:.1f} of AR-BIC, less than {}.", p.name,
                                    with_interval(p), entry.rise, kLeastRise));
  }
}

/// Compares the input with the parameters of G that it was to determine.
void judge_excitation(const Model& model, Judgement& judgement) {
  if (!model.validation || !model.validation->excitation_order) return;
  const auto order = static_cast<double>(*model.validation->excitation_order);
  const auto parameters =
      static_cast<double>(std::count_if(model.parameters.begin(), model.parameters.end(), [](const auto& p) {
        return !p.fixed && (is_order(p.role) || is_coefficient(p.role) || p.role == ParameterRole::delay);
      }));
  judgement.criterion("excitation_order", order, parameters, order >= parameters, Weight::lowers,
                      fmt::format("The input is persistently exciting of order {:g} only (a tone gives 2), less than "
                                  "the {:g} estimated parameters of G: too little excitation to test the model.",
                                  order, parameters));
}

/// Judges whether the record determines what the structure leaves free. The paper's procedure gives no errors.
void judge_parameters(const Model& model, Judgement& judgement) {
  if (!model.estimation || !model.estimation->correlation) return;
  judge_excitation(model, judgement);
  const auto& information = model.estimation->information;
  for (const ParameterEstimate& p : model.parameters) {
    if (p.fixed || is_offset(p.role)) continue;
    if (is_order(p.role)) {
      judge_order(p, information ? information->left_out : std::vector<LeftOut>{}, judgement);
    } else if (is_coefficient(p.role)) {
      // The end of the interval that lies nearer to 0, from its side of 0.
      const double distance = p.value < 0.0 ? -p.upper95 : p.lower95;
      judgement.criterion("interval_" + p.name, distance, 0.0, distance > 0.0, Weight::rejects,
                          fmt::format("{} = {}: compatible with 0, its 95 % interval is {:.3g} to {:.3g}.", p.name,
                                      with_interval(p), p.lower95, p.upper95));
    } else if (std::isfinite(p.std) && p.upper95 - p.lower95 > 2.0 * std::abs(p.value)) {
      judgement.note(fmt::format("The record hardly determines {}: its 95 % interval is {:.3g} to {:.3g}.", p.name,
                                 p.lower95, p.upper95));
    }
  }
}

}  // namespace

std::string_view text(Grade grade) {
  switch (grade) {
    case Grade::good:
      return "good";
    case Grade::usable:
      return "usable";
    case Grade::rejected:
      break;
  }
  return "rejected";
}

Verdict judge(const Model& model, const AcceptanceLimits& limits, const RecordFacts& facts) {
  Judgement judgement;
  judgement.criterion(
      "interpolated_percent", facts.interpolated_percent, kMostInterpolated_percent,
      facts.interpolated_percent <= kMostInterpolated_percent, Weight::rejects,
      fmt::format("{:.3g} % of the record was not measured but interpolated, which is above the limit of {:.3g} %.",
                  facts.interpolated_percent, kMostInterpolated_percent));
  if (model.estimation) {
    judgement.criterion("converged", model.estimation->converged ? 1.0 : 0.0, 1.0, model.estimation->converged,
                        Weight::rejects,
                        fmt::format("The estimation did not converge: it ended after {} evaluations with \"{}\".",
                                    model.estimation->evaluations, model.estimation->termination));
    if (model.estimation->converged && model.estimation->termination == text(Termination::flat_ridge)) {
      judgement.note(
          "The cost is flat along a ridge: the estimates compensate each other there, the output hardly changes.");
    }
  }
  if (model.validation) {
    judge_score(model.validation->score, "validation", model, limits, judgement);
    judge_residual(*model.validation, limits, judgement);
    if (facts.noise_std && *facts.noise_std > 0.0) {
      judge_noise(model, *facts.noise_std, judgement);
    } else if (facts.lacks_periods) {
      judgement.not_judged({{"error_over_noise", std::numeric_limits<double>::quiet_NaN(), kGreatestErrorOverNoise}},
                           "Not judged whether the error is noise: the record holds too few periods of its "
                           "excitation to measure the noise from; play more repetitions.");
    }
  } else if (model.estimation) {
    judge_score(model.estimation->score, "estimation", model, limits, judgement);
    judgement.not_judged(
        {}, "Nothing was kept for validation (split 1): the model is judged by the samples that estimated it.");
  } else {
    judgement.reject("The model was neither estimated nor validated here.");
  }
  judge_stability(model, limits, judgement);
  judge_parameters(model, judgement);
  return judgement.verdict();
}

}  // namespace eha::ident
