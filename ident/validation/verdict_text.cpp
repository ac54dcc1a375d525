// SPDX-License-Identifier: GPL-3.0-or-later
// The sentences of a verdict.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <vector>

#include "ident/model/parameter_text.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/explanation.hpp"
#include "ident/validation/fast_resonance.hpp"
#include "ident/validation/first_step.hpp"
#include "ident/validation/reasons.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident {
namespace {

constexpr double kReachOfNoise = 3.0;     ///< standard deviations that some sample of every record exceeds
constexpr double kHardlyByChance = 1e-4;  ///< of a residual test; below it hardly a sound record among many

using Kind = CriterionKind;

}  // namespace

std::vector<std::string> Reasons::all() {
  if (shows_no_motion(model_, verdict_)) return {no_motion()};
  // What is left over shows the input, and no plant.
  if (cause_ == ErrorCause::wrong_input) return {model_.provenance.at(kWrongInput) + "."};
  if (cause_ == ErrorCause::moved_rows) return {model_.provenance.at(kMovedRows) + "."};
  if (cause_ == ErrorCause::frozen) return frozen();
  // What explains the other reasons comes first.
  about({Kind::unmeasured, Kind::interpolated, Kind::far_saturated, Kind::saturated, Kind::record_length,
         Kind::converged});
  note_flat_ridge();
  if (!model_.estimation && !model_.validation) {
    rejections_.emplace_back(
        "Nothing is known of the model's error: it was neither estimated nor validated here; hold it against a "
        "record (`eha validate`).");
  }
  const bool is_of_another_plant = std::any_of(verdict_.criteria.begin(), verdict_.criteria.end(), [](const auto& c) {
    return c.kind == Kind::error_over_refit && has_failed(c);
  });
  about({Kind::error_over_refit, Kind::slow_pair, Kind::fast_resonance, Kind::between_rows, Kind::r2,
         Kind::max_abs_error});
  // A cause stands before the statistics that show it.
  if (!is_of_another_plant) about({Kind::residual_drift});
  about({Kind::error_over_estimating});
  // What the residual of another plant's model shows says nothing about this one.
  if (!is_of_another_plant) {
    if (is_rather_nonlinear(model_, verdict_)) {
      about({Kind::nonlinearity});
      about({Kind::residual_input});
    } else {
      about({Kind::residual_input});
      about({Kind::nonlinearity});
    }
    about({Kind::future_input});
    about({Kind::residual_whiteness, Kind::predicted_error, Kind::input_levels, Kind::extrapolated});
    note_low_r2();
    about({Kind::error_over_noise, Kind::far_error_over_noise});
  }
  if (model_.estimation && !model_.validation) {
    notes_.emplace_back(
        verdict_.judging_part_rests
            ? "The input does not move in the part that would judge; nothing judges the model: the whole record "
              "estimated it; hold it against another record (`eha validate`), or play an input that moves in both "
              "halves."
            : "Nothing was kept for validation (split 1): the model is judged by the samples that estimated it; keep "
              "a part (--split 0.5), or hold it against another record (`eha validate`).");
  }
  about({Kind::above_recommended});
  note_allowed_instability();
  about({Kind::stability_margin, Kind::excitation_order, Kind::order_error, Kind::left_out, Kind::coefficient_interval,
         Kind::gain_ratio});
  note_wide_intervals();
  note_cancelling_pair();
  std::vector<std::string> all;
  if (explanation_) all.push_back(sentence_of(*explanation_));
  const bool is_off = fails_any(verdict_, kShownBesideGaps) || fails_any(verdict_, {Kind::interpolated}) ||
                      (model_.validation && model_.validation->jump);
  if (const std::string gaps = gaps_in_record(model_); is_off && !gaps.empty()) all.push_back(gaps);
  if (const auto moved = model_.provenance.find(kMovedRows); moved != model_.provenance.end() && shows_in_residual()) {
    all.push_back(moved->second + ".");
  }
  if (cause_ == ErrorCause::slow_rows) all.push_back(slow_rows());
  if (is_in_loop()) all.push_back(loop_in_record_of(model_));
  const std::vector<std::string> causes = causes_in_record(model_);
  all.insert(all.end(), causes.begin(), causes.end());
  for (std::vector<std::string>* sentences : {&rejections_, &notes_}) {
    all.insert(all.end(), sentences->begin(), sentences->end());
  }
  return all;
}

void Reasons::about(std::initializer_list<Kind> kinds) {
  for (const Criterion& criterion : verdict_.criteria) {
    if (criterion.passed || std::find(kinds.begin(), kinds.end(), criterion.kind) == kinds.end()) continue;
    if (is_explained(criterion.kind)) continue;
    const std::string text = criterion.judged ? failed(criterion) : not_judged(criterion);
    if (text.empty()) continue;
    const bool rejects = criterion.judged && traits_of(criterion.kind).weight == CriterionWeight::rejects;
    (rejects ? rejections_ : notes_).push_back(text);
  }
}

std::string Reasons::failed(const Criterion& c) const {
  const std::string unit = after_number(model_.output_unit);
  switch (c.kind) {
    case Kind::interpolated:
      if (c.limit == 0.0) return {};  // gaps_in_record() says it
      return fmt::format(
          "Part of the record was not measured: {:.3g} % of its rows are interpolated{}, more than {:.3g} %; {}.",
          c.value, model_.procedure == "paper" ? "" : " in gaps", c.limit,
          against_lost_rows("cut with --from and --to to a part that was"));
    case Kind::unmeasured:
      return fmt::format(
          "Too little of the record was measured: {:.3g} % of its rows lack a value, more than {:.3g} %; {}.", c.value,
          c.limit, against_lost_rows("cut with --from and --to to a part that lacks fewer"));
    case Kind::record_length:
      if (verdict_.judging_part_rests) {
        return fmt::format(
            "Nearly all of the record stands still: the output is on its way for {:.3g} s of it and has few values, "
            "which any model follows, with any gain; record motion for {:.3g} s or more, up and down.",
            c.value, c.limit);
      }
      return fmt::format(
          "Too short to judge: {:.3g} s, record at least {:.3g} s; other models follow such a piece of the input's "
          "motion as well, with another gain.",
          c.value, c.limit);
    case Kind::converged:
      if (!model_.estimation) return {};
      return fmt::format(
          "The search found no best parameters: after {} evaluations it ended with \"{}\"; fit a simpler model, or "
          "record longer.",
          model_.estimation->evaluations, model_.estimation->termination);
    case Kind::r2:
      if (cause_ == ErrorCause::frozen) return low_r2(c);
      if (cause_ == ErrorCause::drift && wanders(model_, verdict_)) return wandering(c);
      if (model_.grey_box && c.value < kHardlyFollows_percent) {
        return fmt::format(
            "This structure does not follow the record: the {} R2 of {} % is below the limit of {:.4g} %; "
            "fit the ladder, which may (`eha fit --model ladder`).",
            c.parameter, percent_text(c.value), c.limit);
      }
      if (c.value < kNoAnswer_percent && !answers_in_estimation() && !is_cause_named()) {
        if (const auto multiple = model_.provenance.find(kOutputInInput); multiple != model_.provenance.end()) {
          return fmt::format(
              "The input is a multiple of the output in the same row (correlation {}), as a controller makes it that "
              "holds the output at a place, and shows no plant: the {} R2 of {} % is below the limit of {:.4g} %; "
              "record with the loop open, or with a reference that moves.",
              multiple->second, c.parameter, percent_text(c.value), c.limit);
        }
        if (verdict_.error_over_recommended) {
          return fmt::format(
              "This structure does not follow the record, which the recommended one describes: the {} R2 of {} % is "
              "below the limit of {:.4g} %.",
              c.parameter, percent_text(c.value), c.limit);
        }
        return fmt::format(
            "The output hardly answers to the input: the {} R2 of {} % is below the limit of {:.4g} %; were "
            "supply and valve on, was the output off its ends, and are these the right columns (--input, --output)? "
            "Look at the record (`eha plot`).",
            c.parameter, percent_text(c.value), c.limit);
      }
      return low_r2(c);
    case Kind::max_abs_error:
      if (const auto noise = measured_noise(); noise && c.limit < kReachOfNoise * *noise) {
        return fmt::format(
            "No model can keep the limit on the greatest error, {}: the noise alone, {} (rms) between the record's "
            "periods, reaches beyond it, and the greatest {} error is {}; raise max_abs_error.",
            error_text(c.limit, model_.output_unit), error_text(*noise, model_.output_unit), c.parameter,
            error_text(c.value, model_.output_unit));
      }
      return fmt::format(
          "The model is too far off at one place: the greatest {} error of {} is above the limit of "
          "{}; look there in the report, and cut a disturbance with --from or --to.",
          c.parameter, error_text(c.value, model_.output_unit), error_text(c.limit, model_.output_unit));
    case Kind::residual_input:
      return fmt::format(
          "A part of the plant may be missing: the input still moves what the model leaves over (p = {:.2g}, lags up "
          "to 20); {}, or ignore it {}.",
          c.value, remedy(), where_it_matters());
    case Kind::residual_whiteness:
      return fmt::format(
          "Something that is not the input {} the output, such as a load, hum or vibration: what the model "
          "leaves over is no plain noise (p = {:.2g} for lags 1 to 20); ignore it {}, else record longer.",
          // One sound record in a hundred is told so.
          c.value > kHardlyByChance ? "may move" : "moves", c.value, where_it_matters());
    case Kind::nonlinearity:
      if (!model_.validation || !model_.validation->tests || !model_.validation->tests->nonlinearity) return {};
      if (drifts_in_gain()) {
        return fmt::format(
            "The plant changes during the record: what the model leaves over depends on the {} (p = {:.2g}); record "
            "again once the rig is warm, or fit a shorter part of the record (--from, --to).",
            effect_of(model_), c.value);
      }
      return fmt::format(
          "At another amplitude the model is off by another amount, as the plant is not linear as the structure is: "
          "what it leaves over depends on the {}{} (p = {:.2g}); use the model at the recorded amplitudes{}.{}",
          effect_of(model_), effect_on_own_record(), c.value,
          is_rather_nonlinear(model_, verdict_) ? ", or " + against_nonlinearity() : "", friction_in_the_map());
    case Kind::future_input:
      return fmt::format(
          "The output moves the input: the residual correlates with the input that follows (p = {:.2g}), a "
          "controller closes the loop, and the model may be biased; record with the loop open.",
          c.value);
    case Kind::predicted_error:
      if (!model_.validation || !model_.validation->tests || !model_.validation->tests->error) return {};
      return fmt::format(
          "The model is not exact enough: under a fresh input of the same kind expect it to be off by {:.2g} to {:.2g} "
          "% of how far the output moves (its standard deviation), more than {:g} %; record longer.",
          c.value, model_.validation->tests->error->upper, c.limit);
    case Kind::residual_drift:
      return fmt::format(
          "What is left wanders: by {:.3g}{} over the validation part, more than the {:.3g}{} that noise and the "
          "parameters' errors explain; {}.",
          c.value, unit, c.limit, unit,
          cause_ == ErrorCause::drift ? "the sensor, the null or the oil's temperature may have drifted: record when "
                                        "the oil is warm, or shorter"
                                      : "the cause named in the other notes may do that, too");
    case Kind::slow_pair:
      return fmt::format(
          "A drift is taken for the plant: a zero and a pole that nearly cancel are both slower than the record is "
          "long, {:.2g} times; take no gain and no slow time constant from this model{}; the sensor, the supply or "
          "the temperature may have drifted: check them, and record again.",
          c.value, beside_the_drift());
    case Kind::fast_resonance:
      return fast_resonance_sentence(c.value, 0.25 / c.limit);
    case Kind::saturated:
      if (model_.validation && model_.validation->end_stop) return {};  // a note says it, with the time
      return fmt::format(
          "Sensor or actuator saturate: the output stays at its greatest or least value for {:.3g} % of the samples "
          "while the model goes on, more than {:.3g} %: {}",
          c.value, c.limit,
          greater_amplitudes().empty()
              ? "an end stop, or the end of the sensor; record with smaller amplitudes, or cut with --from and --to."
              : "the output rests; " + greater_amplitudes() + ".");
    case Kind::far_saturated:
      return fmt::format(
          "The output stands at an end for {:.3g} % of the samples, more than {:.3g} %: gain and dead band come out "
          "wrong; {}, or record nearer to mid-travel or with a sensor of a wider range.",
          c.value, c.limit, cut_of_record());
    case Kind::extrapolated:
      return fmt::format(
          "The model is tried beyond what it has seen: {:.3g} % of the validating samples have an input outside the "
          "estimating ones, more than {:.3g} %; record both parts with the same amplitudes.",
          c.value, c.limit);
    case Kind::error_over_noise:
    case Kind::far_error_over_noise: {
      if (!model_.validation) return {};
      const Score& score = model_.validation->score;
      const double error = std::sqrt(score.mse);
      const double largest = std::max(std::abs(score.error_min), std::abs(score.error_max));
      // A close fit alone keeps it from rejection.
      const std::string risk =
          c.kind == Kind::error_over_noise && c.value > kFarErrorOverNoise && verdict_.grade != Grade::rejected
              ? fmt::format(
                    ", and every motion repeats it: a fit of {:.3g} % keeps this alone from rejecting it, but expect "
                    "the output up to {} from where the model puts it",
                    score.fit_percent, error_text(largest, model_.output_unit))
              : std::string();
      return fmt::format(
          "The model misses a part of the plant: its validation error of {} (rms) is {:.3g} times the noise "
          "of {} that differs between the record's periods, more than {:.3g}{}; {}, or ignore it {}.",
          error_text(error, model_.output_unit), c.value, error_text(error / c.value, model_.output_unit), c.limit,
          risk, remedy(), where_it_matters());
    }
    case Kind::between_rows:
      return fmt::format(
          "The rows are coarse for this input: where it was a smooth signal, curves through the rows in place of "
          "straight lines change the output by {} (rms), {} % of the error, so that time constants, dead time and "
          "dead band are off by more than their intervals; record more rows a second.",
          error_text(model_.validation->between_rows.value_or(0.0), model_.output_unit), figure_text(c.value));
    case Kind::error_over_refit:
      return fmt::format(
          "It is a model of another plant, or the plant has changed: its error is {:.3g} times that of its structure "
          "fitted to this record, more than {:.3g}, and parameters differ; `eha compare` with both names them; fit a "
          "new model.",
          c.value, c.limit);
    case Kind::error_over_estimating: {
      // A fit that is too low to accept says as much, and a drift explains it.
      if (!model_.validation || fails_any(verdict_, {Kind::r2, Kind::slow_pair})) return {};
      const double error = std::sqrt(model_.validation->score.mse);
      return fmt::format(
          "The model errs more on unseen data than where it was estimated: {} (rms) there, {:.2g} times the {} here, "
          "more than {:.3g}; {}hold the model against another record (`eha validate`) before it is relied on.",
          error_text(error, model_.output_unit), c.value, error_text(error / c.value, model_.output_unit), c.limit,
          drifts_in_gain() ? "" : "record longer, and ");
    }
    case Kind::stability_margin:
      return unstable(c);
    case Kind::excitation_order:
      return fmt::format(
          "The input tests the model too little: it determines {:g} parameters (a tone 2), fewer than the {:g} "
          "estimated ones of G; record with more tones or levels.",
          c.value, c.limit);
    case Kind::order_error:
      return undetermined_order(c);
    case Kind::left_out:
      return fmt::format(
          "The record does not need the term of order {}: without it the model is as good (AR-BIC rises by {:.1f}, "
          "less than {}); use the model without it.",
          estimate(c.parameter), c.value, c.limit);
    case Kind::coefficient_interval: {
      const ParameterEstimate* p = find(c.parameter);
      if (p == nullptr) return {};
      if (!std::isfinite(p->lower95) || !std::isfinite(p->upper95)) {
        return fmt::format(
            "The record does not determine {} by itself: others make up for any change of it, and its 95 % interval "
            "is {}; simulate with it, but take no single parameter of it, or record longer.",
            c.parameter, interval_text(*p));
      }
      if (is_level_out_of_sight(model_, *p)) {
        return fmt::format(
            "The record does not show {}: {:.3g}{} has no upper bound or is beyond 4000 times the output's standard "
            "deviation, for which the plant is linear; use a transfer function (`eha fit --model ladder`).",
            c.parameter, p->value, unit);
      }
      return fmt::format(
          "The record does not need {}: it may be 0, its 95 % interval is {}; use {}, or record "
          "longer.",
          c.parameter, interval_text(*p),
          p->role == ParameterRole::grey_box ? "a transfer function (`eha fit --model ladder`)"
                                             : "the model without it");
    }
    case Kind::above_recommended:
      return fmt::format(
          "Another model describes the record clearly better: the AR-BIC of {} is {:.0f} lower, more than {:g}; take "
          "{}.",
          c.parameter, c.value, c.limit, c.parameter);
    case Kind::gain_ratio:
      return fmt::format(
          "The map is no valve's: its gain below the dead band is {:.3g} times that above, so more volts to one side "
          "would turn the motion round; use the model without the map, or record both sides of the valve.",
          c.value);
    case Kind::wrong_input:  // all() says it alone
    case Kind::jump:         // causes_in_record() says it first
    case Kind::far_jump:
    case Kind::input_noise:
    case Kind::input_levels:
    case Kind::other:
      break;
  }
  return {};
}

std::vector<std::string> reasons_of(const Model& model, const Verdict& verdict) {
  return Reasons(model, verdict).all();
}

std::vector<std::string> also_shown_in(const Model& model, const Verdict& verdict) {
  std::vector<std::string> found;
  for (const Criterion& c : Reasons(model, verdict).explained()) {
    const bool is_probability = traits_of(c.kind).words.ends_with(", p");
    found.push_back(note_of(c) + (is_probability ? fmt::format(" (p = {:.2g})", c.value) : ""));
  }
  return found;
}

}  // namespace eha::ident
