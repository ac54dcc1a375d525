// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "ident/model/record_start.hpp"
#include "ident/statistics/distributions.hpp"
#include "ident/validation/explanation.hpp"
#include "ident/validation/fast_resonance.hpp"
#include "ident/validation/record_findings.hpp"
#include "ident/validation/residual_tests.hpp"
#include "ident/validation/slow_pair.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident {
namespace {

constexpr double kResidualLevel = 0.01;  // of each residual test
constexpr double kCloseFit_percent = 95.0;
constexpr double kExactFit_percent = 99.9;  // what is left is small beside every use, whatever it is a multiple of
constexpr double kMostError_percent = 5.0;  // of the output's standard deviation
constexpr double kMostBetweenRows_percent = 30.0;  // of the residual's rms
constexpr double kMostInputNoise_percent = 10.0;   // of the residual's power
constexpr double kFewestLevels = 3.0;              // of an input that tells of other amplitudes
constexpr double kGreatestOrderError = 0.15;       // standard error of a free order
constexpr double kLeastRise = 10.0;                // of AR-BIC, without an order's term
// A valve that acts to one side has a ratio of 0, to which noise may give a sign.
constexpr double kLeastGainRatio = -0.05;
constexpr double kMostExtrapolated_percent = 5.0;
constexpr double kMostSaturated_percent = 1.0;
constexpr double kFarJump = 0.1;  // of the output's standard deviation
constexpr double kNoticedChance = 0.5;

constexpr double kLongestPair = 1.0;  // records
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
using Kind = CriterionKind;

class Judgement {
 public:
  void criterion(Kind kind, double value, double limit, bool passed, const std::string& parameter = {}) {
    add({.kind = kind, .parameter = parameter, .value = value, .limit = limit, .passed = passed});
    if (!passed) lower(traits_of(kind).weight == CriterionWeight::rejects ? Grade::rejected : Grade::usable);
  }
  /// For a criterion that the record holds too little for.
  void not_judged(Kind kind, double value, double limit) {
    add({.kind = kind, .value = value, .limit = limit, .judged = false});
    lower(Grade::usable);
  }
  [[nodiscard]] bool fails(std::initializer_list<Kind> kinds) const { return fails_any(verdict_, kinds); }
  /// Whether the record holds too little for a criterion, or nothing.
  [[nodiscard]] bool lacks(Kind kind) const {
    return std::none_of(verdict_.criteria.begin(), verdict_.criteria.end(),
                        [&](const Criterion& c) { return c.kind == kind && c.judged; });
  }
  void lower(Grade grade) { verdict_.grade = std::min(verdict_.grade, grade); }

  Verdict verdict() {
    verdict_.accepted = verdict_.grade != Grade::rejected;
    return std::move(verdict_);
  }

 private:
  void add(Criterion criterion) { verdict_.criteria.push_back(std::move(criterion)); }
  Verdict verdict_{.grade = Grade::good};
};

void judge_score(const Score& score, const std::string& part, const AcceptanceLimits& limits, Judgement& judgement) {
  judgement.criterion(Kind::r2, score.r2_percent, limits.min_validation_r2_percent,
                      score.r2_percent >= limits.min_validation_r2_percent, part);
  const double least = std::abs(score.error_min);
  const double greatest = std::abs(score.error_max);
  const double error =
      std::isnan(greatest) ? greatest : std::max(least, greatest);  // max() would drop a NaN on its right
  // Without a limit (infinity) only a NaN fails here.
  judgement.criterion(Kind::max_abs_error, error, limits.max_abs_error, error <= limits.max_abs_error, part);
}

void judge_stability(const Model& model, const AcceptanceLimits& limits, Judgement& judgement) {
  if (!model.stability) {
    if (limits.require_stable) {
      judgement.criterion(Kind::stability_margin, kUnknown, limits.min_stability_margin_rad, false);
    }
    return;
  }
  const StabilityReport& stability = *model.stability;
  const bool forbidden = limits.require_stable && !stability.stable;
  const bool too_near = stability.stable && !(stability.margin_rad >= limits.min_stability_margin_rad);
  judgement.criterion(Kind::stability_margin, stability.margin_rad, limits.min_stability_margin_rad,
                      !forbidden && !too_near);
}

/// Whether a test of the residual would notice that what it looks for makes kNoticedShare of the residual, at least
/// with kNoticedChance: the power of a chi-squared test. @param samples  those that can show it
bool can_notice(const ResidualTest& test, double level, std::size_t samples) {
  if (test.degrees == 0) return false;
  const auto degrees = static_cast<double>(test.degrees);
  const double limit = chi_squared_exceeded(level, degrees);
  const double noncentrality = static_cast<double>(samples) * kNoticedShare / (1.0 - kNoticedShare);
  return chi_squared_share(limit, degrees, noncentrality) >= kNoticedChance;
}

/// What passes a test that would hardly notice anything is not judged.
void judge_test(Kind kind, const ResidualTest& test, double level, std::size_t samples, Judgement& judgement) {
  if (test.p >= level && !can_notice(test, level, samples)) {
    judgement.not_judged(kind, test.p, level);
  } else {
    judgement.criterion(kind, test.p, level, test.p >= level);
  }
}

/// Whether the plant is what the structure can be, and how far off the model is.
/// @param samples  that show an answer of the plant
/// @param is_in_loop  the record shows a controller, whatever the tests say: judge_loop() has that
void judge_plant(const ResidualTests& tests, std::size_t samples, bool is_in_loop, Judgement& judgement) {
  const auto fails_none_before = [&, nonlinear = tests.nonlinearity] {
    return tests.input.p >= kResidualLevel && (!nonlinear || nonlinear->test.p >= kNonlinearLevel);
  };
  if (tests.nonlinearity && tests.nonlinearity->test.degrees > 0) {
    judge_test(Kind::nonlinearity, tests.nonlinearity->test, kNonlinearLevel, samples, judgement);
  }
  // What the plant makes of past input may look like feedback.
  if (!is_in_loop && tests.future_input && tests.future_input->degrees > 0 && fails_none_before()) {
    judge_test(Kind::future_input, *tests.future_input, kFeedbackLevel, samples, judgement);
  }
  if (!tests.error) return;
  const auto [lower, upper] = *tests.error;
  if (upper <= kMostError_percent || lower > kMostError_percent) {
    judgement.criterion(Kind::predicted_error, lower, kMostError_percent, lower <= kMostError_percent);
  } else {
    judgement.not_judged(Kind::predicted_error, upper, kMostError_percent);
  }
}

/// Whether the residual holds a part of the plant, and is noise.
void judge_tests(const ValidationReport& validation, bool is_in_loop, Judgement& judgement) {
  if (!validation.tests) {
    judgement.not_judged(Kind::residual_input, kUnknown, kResidualLevel);
    judgement.not_judged(Kind::residual_whiteness, kUnknown, kResidualLevel);
    judgement.not_judged(Kind::residual_drift, kUnknown, kUnknown);
    return;
  }
  const ResidualTests& tests = *validation.tests;
  const std::size_t samples = answering_samples(validation);
  judge_test(Kind::residual_input, tests.input, kResidualLevel, samples, judgement);
  judge_test(Kind::residual_whiteness, tests.whiteness, kResidualLevel, validation.score.samples, judgement);
  judge_plant(tests, samples, is_in_loop, judgement);
  if (const auto& drift = validation.tests->drift) {
    judgement.criterion(Kind::residual_drift, drift->change, drift->expected, drift->change <= drift->expected);
  }
}

/// Of a record that shows a controller, tests or none.
void judge_loop(const Model& model, Judgement& judgement) {
  if (!model.provenance.contains(kLoopOfRecord)) return;
  const auto& tests = model.validation ? model.validation->tests : std::nullopt;
  judgement.criterion(Kind::future_input, tests && tests->future_input ? tests->future_input->p : 0.0, kFeedbackLevel,
                      false);
}

/// Of a record whose input is not what the plant got: no figure of any model of it holds.
void judge_input(const Model& model, Judgement& judgement) {
  if (model.provenance.contains(kWrongInput)) judgement.criterion(Kind::wrong_input, 1.0, 0.0, false);
}

/// Share of the validating samples at which the output is at its limit [%].
double at_an_end_percent(const ValidationReport& validation) {
  return std::max(validation.saturated_percent.value_or(0.0), validation.end_stop ? validation.end_stop->percent : 0.0);
}

bool stands_at_an_end(const Model& model) {
  return model.validation && at_an_end_percent(*model.validation) > kFarSaturated_percent;
}

void judge_validation(const Model& model, const RecordFacts& facts, Judgement& judgement) {
  const ValidationReport& validation = *model.validation;
  const bool has_lines = validation.between_rows && validation.score.mse > 0.0;
  const double between_percent = has_lines ? 100.0 * *validation.between_rows / std::sqrt(validation.score.mse) : 0.0;
  const bool is_coarse = between_percent > kMostBetweenRows_percent;
  if (has_lines) {
    judgement.criterion(Kind::between_rows, between_percent, kMostBetweenRows_percent, !is_coarse);
  }
  if (const auto& noise = validation.input_noise) {
    // Noise that did not reach the plant is in the input and in what is left over: the tests would find a part of the
    // plant, or a bend of it, in that.
    const double share = 100.0 * noise->share;
    judgement.criterion(Kind::input_noise, share, kMostInputNoise_percent, share <= kMostInputNoise_percent);
  } else if (!is_coarse) {  // the tests would find a part of the plant in what curves leave over, too
    judge_tests(validation, model.provenance.contains(kLoopOfRecord), judgement);
  }
  if (const auto& levels = validation.input_levels) {
    judgement.not_judged(Kind::input_levels, levels->lower < levels->upper ? 2.0 : 1.0, kFewestLevels);
  }
  const auto at_most = [&](Kind kind, const std::optional<double>& share, double limit) {
    if (share) judgement.criterion(kind, *share, limit, *share <= limit);
  };
  const double at_an_end = at_an_end_percent(validation);
  if (validation.saturated_percent || validation.end_stop) {
    // However few samples it is at a stop, the model was fitted to it as well.
    const double most = validation.end_stop ? 0.0 : kMostSaturated_percent;
    judgement.criterion(Kind::saturated, at_an_end, most, at_an_end <= most);
  }
  // Where a part without is to be had, its fit is the one that counts.
  const bool has_part_without = validation.end_stop && !cut_options(*validation.end_stop).empty();
  const double far = has_part_without ? 0.0 : kFarSaturated_percent;
  if (at_an_end > far) judgement.criterion(Kind::far_saturated, at_an_end, far, false);
  // What jumped is in the estimating part or in the error: no figure of this fit holds without the cut.
  if (const auto& jump = validation.jump) {
    judgement.criterion(Kind::jump, std::abs(jump->change), jump->usual, false);
    const double spread = std::sqrt(validation.score.mse / (1.0 - 0.01 * validation.score.r2_percent));
    const double greatest = kFarJump * spread;
    if (jump->estimating && std::abs(jump->change) > greatest) {
      judgement.criterion(Kind::far_jump, std::abs(jump->change), greatest, false);
    }
  }
  at_most(Kind::extrapolated, validation.extrapolated_percent, kMostExtrapolated_percent);
  const auto told = explanation(model);
  const auto factor = told && told->kind == ExplanationKind::play ? explained_factor(*told) : std::optional<double>();
  if (validation.input_noise) {
    // It differs between the periods of the input, and that of the output does not show it.
  } else if (facts.noise_std && *facts.noise_std > 0.0) {
    // The noise that the record's own repetitions show.
    const double ratio = std::sqrt(validation.score.mse) / *facts.noise_std;
    if (ratio > kFarErrorOverNoise && !(validation.score.fit_percent >= kCloseFit_percent)) {
      judgement.criterion(Kind::far_error_over_noise, ratio, kFarErrorOverNoise, false);
    } else {
      at_most(Kind::error_over_noise, ratio, kGreatestErrorOverNoise);
    }
  } else if (factor) {
    // What is left beside the play is the noise that the model is held against.
    judgement.criterion(Kind::error_over_noise, *factor, kGreatestErrorOverNoise, false);
  } else if (facts.lacks_periods) {
    judgement.not_judged(Kind::error_over_noise, kUnknown, kGreatestErrorOverNoise);
  }
}

/// What was not measured says nothing, and what the input did in a gap is not known: the fit takes where an integrating
/// rod stands after one for the plant, and no figure of it holds without the cut.
void judge_unmeasured(const Model& model, const Unmeasured& unmeasured, Judgement& judgement) {
  // The paper's procedure takes interpolated rows for measured ones, and such a row agrees with any smooth model.
  const double interpolated = model.procedure == "paper" ? unmeasured.percent() : unmeasured.in_gaps_percent();
  const bool is_shifted =
      model.provenance.contains(kWithoutGaps) && !comes_to_rest(model) && judgement.fails(kShownBesideGaps);
  const double most = is_shifted ? 0.0 : kMostInterpolated_percent;
  judgement.criterion(Kind::interpolated, interpolated, most, interpolated <= most);
  if (unmeasured.rows == 0) return;
  judgement.criterion(Kind::unmeasured, unmeasured.without_input_percent(), kMostUnmeasured_percent,
                      unmeasured.without_input_percent() <= kMostUnmeasured_percent);
}

/// Many models follow a piece of a motion, and there is nothing to tell them apart by where no test can judge.
void judge_length(const Model& model, const RecordFacts& facts, Judgement& judgement) {
  if (!facts.piece || (!model.validation && !facts.piece->is_too_little)) return;
  const bool is_judged = !model.validation || model.validation->input_noise || !judgement.lacks(Kind::residual_input) ||
                         !judgement.lacks(Kind::predicted_error);
  if (is_judged && !facts.piece->is_too_little) return;
  judgement.criterion(Kind::record_length, facts.piece->length_s, facts.piece->enough_s, false);
}

/// Compares the error on the unseen part with what the estimating one promises.
void judge_unseen_part(const Model& model, Judgement& judgement) {
  if (!model.validation || !model.estimation || !(model.estimation->score.mse > 0.0)) return;
  if (model.validation->input_noise) return;  // which a plant that integrates adds up
  const Score& unseen = model.validation->score;
  if (unseen.fit_percent >= kExactFit_percent) return;
  const double ratio = std::sqrt(unseen.mse / model.estimation->score.mse);
  judgement.criterion(Kind::error_over_estimating, ratio, kGreatestErrorOverEstimating,
                      ratio <= kGreatestErrorOverEstimating);
}

/// Compares the input with the parameters of G that it was to determine.
void judge_excitation(const Model& model, Judgement& judgement) {
  if (!model.validation || !model.validation->excitation_order) return;
  const auto order = static_cast<double>(*model.validation->excitation_order);
  const auto parameters =
      static_cast<double>(std::count_if(model.parameters.begin(), model.parameters.end(), [](const auto& p) {
        return !p.fixed && (is_order(p.role) || is_coefficient(p.role) || p.role == ParameterRole::delay ||
                            p.role == ParameterRole::grey_box);
      }));
  judgement.criterion(Kind::excitation_order, order, parameters, order >= parameters);
}

/// A drift of the output can hide in a pole and a zero that nearly cancel.
void judge_slow_pair(const Model& model, Judgement& judgement) {
  const auto pair = slow_pair_over_record(model);
  if (pair && *pair > kLongestPair) judgement.criterion(Kind::slow_pair, *pair, kLongestPair, false);
}

/// A resonance above the Nyquist frequency shows below it.
void judge_resonance(const Model& model, double row_s, Judgement& judgement) {
  const std::optional<double> resonance_Hz = row_s > 0.0 ? fastest_resonance_Hz(model) : std::nullopt;
  if (!resonance_Hz) return;
  const double from_Hz = ambiguous_from_Hz(row_s);
  judgement.criterion(Kind::fast_resonance, *resonance_Hz, from_Hz, *resonance_Hz <= from_Hz);
}

/// Judges whether the record determines what the structure leaves free. The paper's procedure gives no errors.
void judge_parameters(const Model& model, Judgement& judgement) {
  if (!model.estimation || !model.estimation->correlation) return;
  judge_excitation(model, judgement);
  const auto& information = model.estimation->information;
  for (const ParameterEstimate& p : model.parameters) {
    if (p.fixed || is_offset(p.role)) continue;
    if (is_order(p.role)) {
      judgement.criterion(Kind::order_error, p.std, kGreatestOrderError, p.std <= kGreatestOrderError, p.name);
      if (!information) continue;
      for (const LeftOut& entry : information->left_out) {
        if (entry.order != p.name) continue;
        judgement.criterion(Kind::left_out, entry.rise, kLeastRise, entry.rise >= kLeastRise, p.name);
      }
    } else if (is_coefficient(p.role) || p.role == ParameterRole::grey_box) {
      // The end of the interval that lies nearer to 0, from its side of 0.
      const double distance = p.value < 0.0 ? -p.upper95 : p.lower95;
      const bool is_seen = !is_level_out_of_sight(model, p);
      judgement.criterion(Kind::coefficient_interval, distance, 0.0, distance > 0.0 && is_seen, p.name);
    } else if (p.role == ParameterRole::negative_gain_ratio) {
      judgement.criterion(Kind::gain_ratio, p.value, kLeastGainRatio, p.value >= kLeastGainRatio);
    }
  }
}

}  // namespace

std::size_t answering_samples(const ValidationReport& validation) {
  const std::size_t all = validation.score.samples;
  return validation.tests && validation.tests->moved ? std::min(all, *validation.tests->moved) : all;
}

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
  if (model.estimation) {
    judgement.criterion(Kind::converged, model.estimation->converged ? 1.0 : 0.0, 1.0, model.estimation->converged);
  }
  if (model.validation) {
    judge_score(model.validation->score, "validation", limits, judgement);
    judge_validation(model, facts, judgement);
  } else if (model.estimation) {
    judge_score(model.estimation->score, "estimation", limits, judgement);
    judgement.lower(Grade::usable);
  } else {
    judgement.lower(Grade::rejected);
  }
  judge_unmeasured(model, facts.unmeasured, judgement);
  judge_loop(model, judgement);
  judge_input(model, judgement);
  // Of an output that stands at an end the structure fits another plant, however little that has changed.
  if (facts.error_over_refit && !stands_at_an_end(model)) {
    judgement.criterion(Kind::error_over_refit, *facts.error_over_refit, kGreatestErrorOverRefit,
                        *facts.error_over_refit <= kGreatestErrorOverRefit);
  }
  if (facts.holds_both_parts) judge_unseen_part(model, judgement);
  judge_length(model, facts, judgement);
  judge_stability(model, limits, judgement);
  judge_slow_pair(model, judgement);
  judge_resonance(model, facts.row_s, judgement);
  judge_parameters(model, judgement);
  if (const auto& best = facts.recommended) {
    judgement.criterion(Kind::above_recommended, best->ar_bic_lower_by, kClearGain, best->ar_bic_lower_by <= kClearGain,
                        best->name);
  }
  Verdict verdict = judgement.verdict();
  verdict.beside_ladder = facts.beside_ladder;
  verdict.judging_part_rests = facts.judging_part_rests;
  verdict.explained_by = facts.explained_by;
  verdict.error_over_recommended = facts.error_over_recommended;
  verdict.word = verdict_word(verdict);
  verdict.reasons = reasons_of(model, verdict);
  return verdict;
}

}  // namespace eha::ident
