// SPDX-License-Identifier: GPL-3.0-or-later
// The sentences of a verdict.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ident/fractional/stability.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/model/record_start.hpp"
#include "ident/search/least_squares.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/explanation.hpp"
#include "ident/validation/first_step.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/slow_pair.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident {
namespace {

constexpr double kReachOfNoise = 3.0;  ///< standard deviations that some sample of every record exceeds

using Kind = CriterionKind;

constexpr double kHardlyFollows_percent = 50.0;  // R2 below which other amplitudes are not the first thought
constexpr double kNoAnswer_percent = 20.0;       // R2 below which the input explains next to nothing

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

class Reasons {
 public:
  Reasons(const Model& model, const Verdict& verdict)
      : model_(model), verdict_(verdict), cause_(error_cause(model, verdict)) {
    const bool misses = fails_any(verdict, {Kind::r2, Kind::residual_input, Kind::nonlinearity, Kind::error_over_noise,
                                            Kind::far_error_over_noise});
    if (misses && cause_ != ErrorCause::frozen && cause_ != ErrorCause::slow_rows) explanation_ = explanation(model);
  }

  std::vector<std::string> all() {
    if (shows_no_motion(model_, verdict_)) return {no_motion()};
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
    about({Kind::error_over_refit, Kind::slow_pair, Kind::r2, Kind::max_abs_error});
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
      about({Kind::residual_whiteness, Kind::future_input, Kind::predicted_error, Kind::input_levels,
             Kind::extrapolated});
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
    about({Kind::stability_margin, Kind::excitation_order, Kind::order_error, Kind::left_out,
           Kind::coefficient_interval, Kind::gain_ratio});
    note_wide_intervals();
    note_cancelling_pair();
    std::vector<std::string> all;
    if (explanation_) all.push_back(sentence_of(*explanation_));
    const bool is_off = fails_any(verdict_, {Kind::r2, Kind::max_abs_error, Kind::residual_input, Kind::nonlinearity,
                                             Kind::predicted_error, Kind::residual_drift, Kind::interpolated}) ||
                        (model_.validation && model_.validation->jump);
    if (const std::string gaps = gaps_in_record(model_); is_off && !gaps.empty()) all.push_back(gaps);
    if (cause_ == ErrorCause::slow_rows) all.push_back(slow_rows());
    const std::vector<std::string> causes = causes_in_record(model_);
    all.insert(all.end(), causes.begin(), causes.end());
    for (std::vector<std::string>* sentences : {&rejections_, &notes_}) {
      all.insert(all.end(), sentences->begin(), sentences->end());
    }
    return all;
  }

 private:
  /// The one statement about a sensor that shows nothing: each other one would be about its noise.
  [[nodiscard]] std::string no_motion() const {
    return fmt::format(
        "The sensor shows no motion: the output is plain noise of {} (rms), in which the input has no part; {}.",
        error_text(std::sqrt(model_.validation->score.mse), model_.output_unit), kAgainstNoMotion);
  }

  /// What is left over shows the sensor there, no plant: no statement on it.
  [[nodiscard]] std::vector<std::string> frozen() {
    about({Kind::r2, Kind::max_abs_error});
    rejections_.insert(rejections_.begin(), frozen_in_record(model_));
    return rejections_;
  }

  /// Whether a sentence before says what keeps the model from following.
  [[nodiscard]] bool is_cause_named() const {
    return cause_ == ErrorCause::frozen || cause_ == ErrorCause::slow_rows || cause_ == ErrorCause::end_stop ||
           cause_ == ErrorCause::jump || cause_ == ErrorCause::input_noise || explanation_;
  }

  /// "The output answers within one row ..."
  [[nodiscard]] std::string slow_rows() const {
    std::string text = model_.provenance.at(kSlowRows) + ".";
    text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
    return text;
  }

  /// Whether another sentence says what makes a criterion fail, or the criterion sees that alone.
  [[nodiscard]] bool is_explained(Kind kind) const {
    const bool is_of_residual =
        kind == Kind::residual_input || kind == Kind::nonlinearity || kind == Kind::residual_whiteness ||
        kind == Kind::future_input || kind == Kind::predicted_error || kind == Kind::residual_drift ||
        kind == Kind::error_over_noise || kind == Kind::far_error_over_noise || kind == Kind::error_over_estimating;
    if (is_of_residual && (explanation_ || cause_ == ErrorCause::slow_rows)) return true;
    if (is_cut_advised() && (kind == Kind::residual_whiteness || kind == Kind::predicted_error)) return true;
    // What the plant makes of its input is no noise either.
    if (kind == Kind::residual_whiteness) return fails_any(verdict_, {Kind::residual_input, Kind::nonlinearity});
    return kind == Kind::residual_input && fails_any(verdict_, {kind}) && is_rather_nonlinear(model_, verdict_);
  }

  /// Whether a part of the record that is none of the plant is named, which what is left over then shows.
  [[nodiscard]] bool is_cut_advised() const {
    return cause_ == ErrorCause::end_stop || cause_ == ErrorCause::jump || !gaps_in_record(model_).empty();
  }

  /// "cut with --from 3 --to 8", the longest part that does not stand at an end.
  [[nodiscard]] std::string cut_of_record() const {
    const auto cut = model_.provenance.find(kCutOfRecord);
    return cut == model_.provenance.end() ? "cut that part" : "cut with " + cut->second;
  }
  /// "; beside the drift the plant is about K = 1.79 V/V; T = 0.492 s".
  [[nodiscard]] std::string beside_the_drift() const {
    const std::string form = form_without_slow_pair(model_);
    return form.empty() ? "" : "; beside the drift the plant is about " + form;
  }
  /// ", or, as its own record has it, on the direction of motion, ..." where that shows another effect.
  [[nodiscard]] std::string effect_on_own_record() const {
    const auto own = model_.provenance.find(kEffectOnOwnRecord);
    return own == model_.provenance.end() ? std::string() : ", or, as its own record has it, on the " + own->second;
  }

  /// "fit the structure with dry friction (`eha fit --model friction`), which errs 0.4 times as much"; empty where no
  /// such fit is known to hold.
  [[nodiscard]] std::string better_grey_box() const {
    const GreyBoxKind* kind = grey_box_to_advise(model_, verdict_);
    if (kind == nullptr) return {};
    return fmt::format("fit the structure with {} (`eha fit --model {}`), which {}", kind->effect, kind->name,
                       model_.provenance.at(kGreyBoxHolds));
  }

  /// A map takes dry friction for a dead band.
  [[nodiscard]] std::string_view friction_in_the_map() const {
    const NonlinearKind kind = model_.validation->tests->nonlinearity->kind;
    if (!model_.input_map || (kind != NonlinearKind::motion && kind != NonlinearKind::direction)) return "";
    return " The map's half dead band then holds what friction takes, too: `eha characterise` measures the valve's "
           "alone.";
  }

  void about(std::initializer_list<Kind> kinds) {
    for (const Criterion& criterion : verdict_.criteria) {
      if (criterion.passed || std::find(kinds.begin(), kinds.end(), criterion.kind) == kinds.end()) continue;
      if (is_explained(criterion.kind)) continue;
      const std::string text = criterion.judged ? failed(criterion) : not_judged(criterion);
      if (text.empty()) continue;
      const bool rejects = criterion.judged && traits_of(criterion.kind).weight == CriterionWeight::rejects;
      (rejects ? rejections_ : notes_).push_back(text);
    }
  }

  /// What is wrong, the figure, what to do.
  [[nodiscard]] std::string failed(const Criterion& c) const {
    const std::string unit = after_number(model_.output_unit);
    switch (c.kind) {
      case Kind::interpolated:
        return fmt::format(
            "Part of the record was not measured: {:.3g} % of its rows are interpolated{}, more than {:.3g} %; cut "
            "with --from and --to to a part that was, or record again.",
            c.value, model_.procedure == "paper" ? "" : " in gaps", c.limit);
      case Kind::unmeasured:
        return fmt::format(
            "Too little of the record was measured: {:.3g} % of its rows lack a value, more than {:.3g} %; cut with "
            "--from and --to to a part that lacks fewer, keep every nth row where the sensor is read so seldom, or "
            "record again.",
            c.value, c.limit);
      case Kind::record_length:
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
              "fit the ladder, which may (`eha fit` without --model).",
              c.parameter, percent_text(c.value), c.limit);
        }
        if (c.value < kNoAnswer_percent && !answers_in_estimation() && !is_cause_named()) {
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
            "The input still moves what the model leaves over (p = {:.2g}, lags up to 20): a part of the plant may "
            "be missing; {}, or ignore it {}.",
            c.value, remedy(), where_it_matters());
      case Kind::residual_whiteness:
        return fmt::format(
            "Something that is not the input moves the output, such as a load, hum or vibration: what the model "
            "leaves over is no plain noise (p = {:.2g} for lags 1 to 20); ignore it {}, else record longer.",
            c.value, where_it_matters());
      case Kind::nonlinearity:
        if (!model_.validation || !model_.validation->tests || !model_.validation->tests->nonlinearity) return {};
        return fmt::format(
            "The plant is not linear as the structure is: the residual depends on the {}{} (p = {:.2g}), and at "
            "another amplitude the error is another one; use the model at the recorded amplitudes{}.{}",
            effect_of(*model_.validation->tests->nonlinearity), effect_on_own_record(), c.value,
            is_rather_nonlinear(model_, verdict_) ? ", or " + against_nonlinearity() : "", friction_in_the_map());
      case Kind::future_input:
        return fmt::format(
            "The output moves the input: the residual correlates with the input that follows (p = {:.2g}), a "
            "controller closes the loop, and the model may be biased; record with the loop open.",
            c.value);
      case Kind::predicted_error:
        if (!model_.validation || !model_.validation->tests || !model_.validation->tests->error) return {};
        return fmt::format(
            "The model is not exact enough: on a fresh input of the same kind it is predicted to be off by {:.2g} to "
            "{:.2g} % of the output's standard deviation, more than {:g} %; record longer.",
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
            c.kind == Kind::error_over_noise && c.value > kFarErrorOverNoise
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
            "more than {:.3g}; record longer, and hold the model against another record (`eha validate`) before it is "
            "relied on.",
            error_text(error, model_.output_unit), c.value, error_text(error / c.value, model_.output_unit), c.limit);
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
        return fmt::format(
            "The record does not need {}: it may be 0, its 95 % interval is {}; use {}, or record "
            "longer.",
            c.parameter, interval_text(*p),
            p->role == ParameterRole::grey_box ? "a transfer function (`eha fit` without --model)"
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
      case Kind::jump:  // causes_in_record() says it first
      case Kind::input_noise:
      case Kind::input_levels:
      case Kind::other:
        break;
    }
    return {};
  }

  /// Whether the output answered to the input in the part that estimated.
  [[nodiscard]] bool answers_in_estimation() const {
    return model_.estimation && model_.estimation->score.r2_percent >= kNoAnswer_percent;
  }

  /// The same of a slow part of the error alone.
  [[nodiscard]] std::string wandering(const Criterion& c) const {
    return fmt::format(
        "The output wanders, whatever the input does: the model follows its faster motion, R2 {} %, and all of it "
        "to {} R2 {} %, below the limit of {:.4g} %; the sensor, the null or the oil's temperature may have "
        "drifted: check the sensor and its supply, and record again, or fit a part in which it hardly wanders "
        "(--from, --to).",
        percent_text(*model_.validation->faster_r2_percent), c.parameter, percent_text(c.value), c.limit);
  }

  /// Why R2 is low, by the cause of the error.
  [[nodiscard]] std::string low_r2(const Criterion& c) const {
    if (cause_ == ErrorCause::white_noise) {
      return fmt::format(
          "What is left is plain noise of {} rms, in which the input has no part: the {} R2 of {} % is "
          "below the limit of {:.4g} %; {}.",
          error_text(std::sqrt(model_.validation->score.mse), model_.output_unit), c.parameter, percent_text(c.value),
          c.limit, kAgainstNoise);
    }
    return fmt::format("The model does not follow the record: the {} R2 of {} % is below the limit of {:.4g} %; {}",
                       c.parameter, percent_text(c.value), c.limit,
                       cause_ == ErrorCause::input_noise ? "the noise of the measured input does that."
                       : explanation_                    ? against_explanation()
                       : cause_ == ErrorCause::slow_rows ? "record more rows a second."
                       : is_cause_named()                ? "cut as said above, and fit again."
                       : !better_grey_box().empty()      ? better_grey_box() + "."
                       : c.value < kHardlyFollows_percent
                           ? "look at the record: did the output move because of this input (volts beyond "
                             "a dead band, supply on, the right columns)?"
                           : "look at the error over time, and " + remedy() + ".");
  }

  /// What the other structure that explains the error asks for.
  [[nodiscard]] std::string against_explanation() const {
    return explanation_->options.empty() ? "record as said above." : "fit that structure.";
  }

  /// One width, the greater of the interval's and the one that the standard error gives.
  [[nodiscard]] std::string undetermined_order(const Criterion& c) const {
    const ParameterEstimate* p = find(c.parameter);
    const double half_width = std::max(kInterval95 * c.value, p == nullptr ? 0.0 : half_width95(*p));
    const std::string value = p == nullptr ? c.parameter : fmt::format("{} = {:.3g}", c.parameter, p->value);
    return fmt::format(
        "The record hardly determines the order {}: its 95 % interval is +- {:.2g}, more than +- {:.2g}; use a model "
        "of fewer parameters, or record longer.",
        value, half_width, kInterval95 * c.limit);
  }

  /// The noise that differs between the record's periods, from the error in multiples of it; none where not measured.
  [[nodiscard]] std::optional<double> measured_noise() const {
    constexpr double kKnown = 1e-300;
    if (!model_.validation) return std::nullopt;
    for (const Criterion& c : verdict_.criteria) {
      const bool is_over_noise = c.kind == Kind::error_over_noise || c.kind == Kind::far_error_over_noise;
      if (is_over_noise && c.judged && c.value > kKnown) return std::sqrt(model_.validation->score.mse) / c.value;
    }
    return std::nullopt;
  }

  /// "record greater amplitudes, as ..." where the input hardly leaves the dead band; else empty.
  [[nodiscard]] std::string greater_amplitudes() const {
    const auto within = model_.provenance.find(kWithinDeadBand);
    return within == model_.provenance.end() ? std::string() : "record greater amplitudes, as " + within->second;
  }

  /// Whether a model that comes to rest was fitted by itself without a dead time, which a heater or a pipe has: what is
  /// left over then follows the motion, as friction's does.
  [[nodiscard]] bool may_lack_dead_time() const {
    if (verdict_.beside_ladder || model_.grey_box || model_.transfer_function.delay_s > 0.0) return false;
    const bool is_estimated = std::any_of(model_.parameters.begin(), model_.parameters.end(),
                                          [](const auto& p) { return p.role == ParameterRole::delay && !p.fixed; });
    return !is_estimated && comes_to_rest(model_);
  }

  /// What may describe more of the plant.
  [[nodiscard]] std::string remedy() const {
    if (!verdict_.explained_by.empty()) {
      return fmt::format(
          "{}, which is accepted too, leaves nothing over that the input moves: take it where "
          "this matters",
          verdict_.explained_by);
    }
    if (may_lack_dead_time()) {
      return fmt::format("let a dead time be estimated (--delay free){}",
                         model_.input_map ? "" : ", or try the valve map (--input-map valve)");
    }
    if (is_rather_nonlinear(model_, verdict_)) return against_nonlinearity();
    if (const std::string greater = greater_amplitudes(); !greater.empty()) return greater;
    if (!better_grey_box().empty()) return better_grey_box();
    if (noted_shift(model_)) {
      return "measure the valve, whose sheet tells a leak from friction (`eha characterise`)";
    }
    if (verdict_.beside_ladder) {
      return fails_any(verdict_, {Kind::nonlinearity}) || !comes_to_rest(model_)
                 ? "as every structure of the ladder was tried, record smaller amplitudes, where a plant is nearer to "
                   "linear"
                 : "as every structure of the ladder was tried, try more poles (`eha fit --model io --poles 5 --zeros "
                   "4`)";
    }
    return model_.input_map || model_.grey_box ? "fit the other structures too (`eha fit` without --model)"
                                               : "try the valve map (--input-map valve)";
  }

  /// What helps against the nonlinear effect that a model shows.
  [[nodiscard]] std::string against_nonlinearity() const {
    const NonlinearityTest& test = *model_.validation->tests->nonlinearity;
    const std::string box = better_grey_box().empty() ? std::string() : better_grey_box() + ", or ";
    if (test.kind == NonlinearKind::motion || test.kind == NonlinearKind::direction) {
      const auto full = model_.provenance.find(kAtCommandLimit);
      const std::string larger =
          full == model_.provenance.end()
              ? "record larger amplitudes, beside which friction and play are small"
              : "reduce friction and play on the rig, as larger amplitudes have no room: " + full->second;
      // Where the rod goes back to a rest.
      const bool has_spring = box.empty() && !model_.grey_box && comes_to_rest(model_);
      return has_spring ? larger +
                              "; no structure here has both friction and a rest to which the output returns (a "
                              "spring): the structure friction is of a rod that integrates"
                        : box + larger;
    }
    if (test.kind == NonlinearKind::level && test.gain == GainTrend::falls) {
      return "record smaller amplitudes, below which nothing saturates, or cut to a part with such (--from, --to)";
    }
    if (const std::string greater = greater_amplitudes(); !greater.empty()) return greater;
    if (test.kind == NonlinearKind::position) return box + "record a smaller travel";
    if (verdict_.beside_ladder || model_.input_map || model_.grey_box) {
      return box + "record smaller amplitudes, where a plant is nearer to linear";
    }
    return "try the valve map (--input-map valve)";
  }
  /// "where an error of 0.012 in does not matter"
  [[nodiscard]] std::string where_it_matters() const {
    if (!model_.validation) return "where the error does not matter";
    return fmt::format("where an error of {} (rms) does not matter",
                       error_text(std::sqrt(model_.validation->score.mse), model_.output_unit));
  }

  [[nodiscard]] std::string not_judged(const Criterion& c) const {
    // The measured noise shows it already.
    if (c.kind == Kind::residual_input && fails_any(verdict_, {Kind::error_over_noise, Kind::far_error_over_noise})) {
      return {};
    }
    if (!model_.validation) return {};
    const std::size_t samples = model_.validation->score.samples;
    if (c.kind == Kind::residual_input && std::isnan(c.value)) {
      return fmt::format(
          "Not judged whether the model misses a part of the plant: {} validating samples are too few for the "
          "residual's tests; record longer.",
          samples);
    }
    if (c.kind == Kind::residual_input) {
      return fmt::format("Not judged whether the model misses a part of the plant: {}.", lacks_power());
    }
    if (c.kind == Kind::nonlinearity && is_judged(Kind::residual_input)) {
      return fmt::format("Not judged whether the plant is linear: {}.", lacks_power());
    }
    if (c.kind == Kind::residual_whiteness && !std::isnan(c.value) && is_judged(Kind::residual_input)) {
      return fmt::format(
          "Not judged whether what is left is plain noise: {} validating samples are too few; record "
          "longer.",
          samples);
    }
    if (c.kind == Kind::future_input && is_judged(Kind::residual_input) && is_judged(Kind::nonlinearity)) {
      return fmt::format("Not judged whether the output moves the input: {}.", lacks_power());
    }
    if (c.kind == Kind::predicted_error && model_.validation->tests && model_.validation->tests->error) {
      return fmt::format(
          "Not judged how exact the model is: on a fresh input of the same kind it is off by {:.2g} to "
          "{:.2g} % of the output's standard deviation; play more repetitions, which tell noise from error.",
          model_.validation->tests->error->lower, c.value);
    }
    if (c.kind == Kind::input_levels && model_.validation->input_levels) {
      return fmt::format("{} for inputs of {} as recorded; no statement about other amplitudes: play more levels.",
                         passes_the_rest() ? "Good" : "Judged",
                         levels_text(*model_.validation->input_levels, model_.input_unit));
    }
    if (c.kind == Kind::error_over_noise) {
      return "Not judged how far the error lies above the noise: the record holds too few periods of its excitation, "
             "less than 2 behind the discarded time, to measure the noise from; play more repetitions.";
    }
    return {};
  }

  /// Why a residual test that passes says little, and what to do.
  [[nodiscard]] std::string lacks_power() const {
    const std::size_t all = model_.validation->score.samples;
    const std::size_t answering = answering_samples(*model_.validation);
    const std::string miss =
        fmt::format("the test would more likely miss than detect what makes {:.0f} % of the residual's power",
                    100.0 * kNoticedShare);
    if (2 * answering > all) return fmt::format("with {} validating samples {}; record longer", all, miss);
    return fmt::format(
        "the input moves within 20 samples of only {} of the {} validating ones, with which {}; play an input that "
        "moves more often (a multisine), or record longer",
        answering, all, miss);
  }

  [[nodiscard]] bool is_judged(Kind kind) const {
    return std::none_of(verdict_.criteria.begin(), verdict_.criteria.end(),
                        [&](const Criterion& c) { return c.kind == kind && !c.judged; });
  }

  /// Whether every criterion passed but that of the input's levels.
  [[nodiscard]] bool passes_the_rest() const {
    return std::all_of(verdict_.criteria.begin(), verdict_.criteria.end(),
                       [](const Criterion& c) { return c.passed || c.kind == Kind::input_levels; });
  }

  [[nodiscard]] std::string unstable(const Criterion& c) const {
    if (!model_.stability) {
      return "The model's stability was not determined, and the limits require it; fit it again, or allow it with "
             "require_stable = false in [acceptance].";
    }
    const StabilityReport& stability = *model_.stability;
    if (stability.stable) {
      return fmt::format(
          "The model is nearly unstable: its stability margin of {:.4g} rad is below the limit of {:.4g} rad; record "
          "longer, or lower min_stability_margin_rad in [acceptance].",
          c.value, c.limit);
    }
    if (only_integrates(model_.transfer_function)) {
      return "The model integrates, and the limits require a stable one; [acceptance] require_stable = false of an "
             "experiment file allows it.";
    }
    return fmt::format(
        "The model is unstable (test: {}, margin {:.4g} rad), and the limits require a stable one; record longer, or "
        "fit a simpler model.",
        stability.test, stability.margin_rad);
  }

  void note_flat_ridge() {
    if (!model_.estimation || !model_.estimation->converged) return;
    if (model_.estimation->termination != text(Termination::flat_ridge)) return;
    const auto& known = model_.estimation->correlation;
    const std::string names = known && !known->indistinguishable.empty()
                                  ? fmt::format(" ({})", fmt::join(known->indistinguishable, ", "))
                                  : "";
    notes_.push_back(
        fmt::format("Several parameters{} compensate each other: the cost is flat along a ridge, and the output hardly "
                    "changes; use the model as a whole, no single value of it, or record longer.",
                    names));
  }

  void note_low_r2() {
    const auto r2 = std::find_if(verdict_.criteria.begin(), verdict_.criteria.end(),
                                 [](const Criterion& c) { return c.kind == Kind::r2; });
    if (!model_.validation || r2 == verdict_.criteria.end() || !(r2->value < r2->limit)) return;
    if (leads(model_.validation->ccf)) {
      notes_.emplace_back(
          "Input and output may be exchanged, or a controller closes the loop: the residual correlates with future "
          "input more than with past input; check --input and --output, or record in open loop.");
    }
    if (!model_.validation->offset_reestimated) return;
    const double anew = model_.validation->offset_reestimated->r2_percent;
    if (!(anew >= r2->limit)) return;
    const bool is_open = cause_ == ErrorCause::unknown;
    notes_.push_back(fmt::format(
        "The error of the validation part is mostly an offset: with one estimated anew there R2 is {} %; {}.",
        percent_text(anew),
        is_open ? "the sensor, the null or the oil's temperature may have drifted between the two parts: record when "
                  "the oil is warm, or shorter"
                : "the cause named in the other notes may do that, too"));
  }

  void note_allowed_instability() {
    const bool allowed = std::any_of(verdict_.criteria.begin(), verdict_.criteria.end(),
                                     [](const Criterion& c) { return c.kind == Kind::stability_margin && c.passed; });
    if (!allowed || !model_.stability || model_.stability->stable) return;
    notes_.push_back(
        fmt::format("The model is unstable (test: {}, margin {:.4g} rad), which the limits allow; simulate "
                    "it no longer than the record, or within a closed loop.",
                    model_.stability->test, model_.stability->margin_rad));
  }

  void note_wide_intervals() {
    if (!model_.estimation || !model_.estimation->correlation) return;
    for (const ParameterEstimate& p : model_.parameters) {
      if (p.fixed || is_offset(p.role) || is_order(p.role) || is_coefficient(p.role)) continue;
      if (!std::isfinite(p.std) || !(p.upper95 - p.lower95 > 2.0 * std::abs(p.value))) continue;
      notes_.push_back(
          fmt::format("The record hardly determines {} = {:.3g}: its 95 % interval is {}; record longer to "
                      "know it.",
                      p.name, p.value, interval_text(p)));
    }
  }

  void note_cancelling_pair() {
    const auto pair = cancelling_pair(model_);
    if (!pair || !rejections_.empty() || takes_in_a_drift(verdict_)) return;
    const double most = std::max(pair->pole_s / pair->zero_s, pair->zero_s / pair->pole_s) - 1.0;
    notes_.push_back(fmt::format(
        "A pole and a zero nearly cancel: T = {:.3g} s and TD = {:.3g} s together change the response by at "
        "most {:.2g} %; take them for a small correction of the fit, not for time constants of the rig.",
        pair->pole_s, pair->zero_s, 100.0 * most));
  }

  [[nodiscard]] const ParameterEstimate* find(const std::string& name) const {
    const auto at = std::find_if(model_.parameters.begin(), model_.parameters.end(),
                                 [&](const ParameterEstimate& p) { return p.name == name; });
    return at == model_.parameters.end() ? nullptr : &*at;
  }
  /// "n2 = 1.75 +- 0.05"
  [[nodiscard]] std::string estimate(const std::string& name) const {
    const ParameterEstimate* p = find(name);
    return p == nullptr ? name : fmt::format("{} = {}", name, with_interval(*p));
  }

  const Model& model_;
  const Verdict& verdict_;
  const ErrorCause cause_;
  std::optional<Explanation> explanation_;
  std::vector<std::string> rejections_;
  std::vector<std::string> notes_;
};

}  // namespace

std::vector<std::string> reasons_of(const Model& model, const Verdict& verdict) {
  return Reasons(model, verdict).all();
}

}  // namespace eha::ident
