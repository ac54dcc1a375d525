// SPDX-License-Identifier: GPL-3.0-or-later
// What the error of a model says of the plant, and what helps.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ident/model/parameter_text.hpp"
#include "ident/model/record_start.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/reasons.hpp"
#include "ident/validation/slow_pair.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident {
namespace {

using Kind = CriterionKind;

constexpr std::string_view kMeasureTheValve =
    "measure the valve (`eha characterise`): a sheet that shows no leak leaves friction, play or a curved gain";

}  // namespace

std::string Reasons::no_motion() const {
  return fmt::format(
      "The sensor shows no motion: the output is plain noise of {} (rms), in which the input has no part; {}.",
      error_text(std::sqrt(model_.validation->score.mse), model_.output_unit), kAgainstNoMotion);
}

std::vector<std::string> Reasons::frozen() {
  about({Kind::r2, Kind::max_abs_error});
  rejections_.insert(rejections_.begin(), frozen_in_record(model_));
  return rejections_;
}

bool Reasons::is_cause_named() const {
  return cause_ == ErrorCause::wrong_input || cause_ == ErrorCause::moved_rows || cause_ == ErrorCause::frozen ||
         cause_ == ErrorCause::slow_rows || is_in_loop() || cause_ == ErrorCause::end_stop ||
         cause_ == ErrorCause::jump || cause_ == ErrorCause::input_noise || explanation_;
}

bool Reasons::shows_in_residual() const {
  return fails_any(verdict_, {Kind::residual_input, Kind::nonlinearity, Kind::future_input, Kind::residual_whiteness});
}

bool Reasons::is_in_loop() const { return cause_ == ErrorCause::feedback && model_.provenance.contains(kLoopOfRecord); }

std::string Reasons::slow_rows() const {
  std::string text = model_.provenance.at(kSlowRows) + ".";
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

bool Reasons::is_explained(Kind kind) const {
  const bool is_of_residual =
      kind == Kind::residual_input || kind == Kind::nonlinearity || kind == Kind::residual_whiteness ||
      kind == Kind::future_input || kind == Kind::predicted_error || kind == Kind::residual_drift ||
      kind == Kind::error_over_noise || kind == Kind::far_error_over_noise || kind == Kind::error_over_estimating;
  const bool is_named = explanation_ || cause_ == ErrorCause::slow_rows || is_in_loop() || rounding_makes_most(model_);
  if (is_of_residual && is_named) return true;
  if (is_cut_advised() && (kind == Kind::residual_whiteness || kind == Kind::predicted_error)) return true;
  // What the plant makes of its input is no noise either.
  if (kind == Kind::residual_whiteness) {
    // Nor is what rounding leaves of a slow motion.
    return fails_any(verdict_, {Kind::residual_input, Kind::nonlinearity}) ||
           (model_.validation && model_.validation->sensor_step);
  }
  return kind == Kind::residual_input && fails_any(verdict_, {kind}) && is_rather_nonlinear(model_, verdict_);
}

std::vector<Criterion> Reasons::explained() const {
  std::vector<Criterion> found;
  std::copy_if(verdict_.criteria.begin(), verdict_.criteria.end(), std::back_inserter(found),
               [&](const Criterion& c) { return has_failed(c) && is_explained(c.kind); });
  return found;
}

bool Reasons::is_cut_advised() const {
  return cause_ == ErrorCause::end_stop || cause_ == ErrorCause::jump || !gaps_in_record(model_).empty();
}

std::string Reasons::cut_of_record() const {
  const auto cut = model_.provenance.find(kCutOfRecord);
  return cut == model_.provenance.end() ? "cut that part" : "cut with " + cut->second;
}

std::string Reasons::against_lost_rows(std::string_view of_file) const {
  const auto of_run = model_.provenance.find(kAgainstLostRows);
  return of_run == model_.provenance.end() ? fmt::format("{}, or record again", of_file) : of_run->second;
}

std::string Reasons::beside_the_drift() const {
  const std::string form = form_without_slow_pair(model_);
  return form.empty() ? "" : "; beside the drift the plant is about " + form;
}

std::string Reasons::effect_on_own_record() const {
  const auto own = model_.provenance.find(kEffectOnOwnRecord);
  return own == model_.provenance.end() ? std::string() : ", or, as its own record has it, on the " + own->second;
}

std::string Reasons::better_grey_box() const {
  const GreyBoxKind* kind = grey_box_to_advise(model_, verdict_);
  if (kind == nullptr) return {};
  return fmt::format("fit the structure with {} (`eha fit --model {}`), which {}", kind->effect, kind->name,
                     model_.provenance.at(kGreyBoxHolds));
}

std::string_view Reasons::friction_in_the_map() const {
  const NonlinearKind kind = model_.validation->tests->nonlinearity->kind;
  if (!model_.input_map || unfound_dead_band(model_) ||
      (kind != NonlinearKind::motion && kind != NonlinearKind::direction))
    return "";
  return " The map's half dead band then holds what friction takes, too: `eha characterise` measures the valve's "
         "alone.";
}

bool Reasons::answers_in_estimation() const {
  return model_.estimation && model_.estimation->score.r2_percent >= kNoAnswer_percent;
}

std::string Reasons::wandering(const Criterion& c) const {
  return fmt::format(
      "The output wanders, whatever the input does: the model follows its faster motion, R2 {} %, and all of it "
      "to {} R2 {} %, below the limit of {:.4g} %; the sensor, the null or the oil's temperature may have "
      "drifted: check the sensor and its supply, and record again, or fit a part in which it hardly wanders "
      "(--from, --to).",
      percent_text(*model_.validation->faster_r2_percent), c.parameter, percent_text(c.value), c.limit);
}

std::string Reasons::low_r2(const Criterion& c) const {
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
                     : is_in_loop()                    ? "record with the loop open."
                     : is_cause_named()                ? "cut as said above, and fit again."
                     : !better_grey_box().empty()      ? better_grey_box() + "."
                     : c.value < kHardlyFollows_percent
                         ? "look at the record: did the output move because of this input (volts beyond "
                           "a dead band, supply on, the right columns)?"
                         : "look at the error over time, and " + remedy() + ".");
}

std::string Reasons::against_explanation() const {
  switch (explanation_->kind) {
    case ExplanationKind::structure:
      return "fit that structure.";
    case ExplanationKind::limit:
      return "record as said above.";
    case ExplanationKind::power:
      return "fit that power as said above.";
    case ExplanationKind::play:
      return "mend what is loose, as said above.";
  }
  return {};
}

std::optional<double> Reasons::measured_noise() const {
  constexpr double kKnown = 1e-300;
  if (!model_.validation) return std::nullopt;
  for (const Criterion& c : verdict_.criteria) {
    const bool is_over_noise = c.kind == Kind::error_over_noise || c.kind == Kind::far_error_over_noise;
    if (is_over_noise && c.judged && c.value > kKnown) return std::sqrt(model_.validation->score.mse) / c.value;
  }
  return std::nullopt;
}

std::string Reasons::greater_amplitudes() const {
  const auto within = model_.provenance.find(kWithinDeadBand);
  return within == model_.provenance.end() ? std::string() : "record greater amplitudes, as " + within->second;
}

bool Reasons::asks_for_smaller_amplitudes() const {
  const bool stands_at_an_end =
      fails_any(verdict_, {Kind::saturated, Kind::far_saturated}) || (model_.validation && model_.validation->end_stop);
  return (stands_at_an_end && greater_amplitudes().empty()) ||
         (explanation_ && explanation_->kind == ExplanationKind::limit);
}

bool Reasons::drifts_in_gain() const {
  return nonlinear_kind(model_, verdict_) == NonlinearKind::time && !model_.validation->tests->nonlinearity->or_kind;
}

bool Reasons::may_lack_dead_time() const {
  if (verdict_.beside_ladder || model_.grey_box || model_.transfer_function.delay_s > 0.0) return false;
  const bool is_estimated = std::any_of(model_.parameters.begin(), model_.parameters.end(),
                                        [](const auto& p) { return p.role == ParameterRole::delay && !p.fixed; });
  return !is_estimated && comes_to_rest(model_);
}

bool Reasons::tells_few_parameters() const {
  constexpr std::size_t kOfFivePoles = 10;  // with four zeros
  const auto& order = model_.validation->excitation_order;
  return order && *order < kOfFivePoles;
}

std::string Reasons::remedy() const {
  if (is_in_loop()) return "record with the loop open";
  if (!verdict_.explained_by.empty()) {
    return fmt::format(
        "{}, which is accepted too, leaves nothing over that the tests show the input to move: take it where this "
        "matters",
        verdict_.explained_by);
  }
  if (may_lack_dead_time()) {
    return fmt::format("let a dead time be estimated (--delay free){}",
                       model_.input_map ? "" : ", or try the valve map (--input-map valve)");
  }
  if (is_rather_nonlinear(model_, verdict_)) return against_nonlinearity();
  if (const std::string greater = greater_amplitudes(); !greater.empty()) return greater;
  if (!better_grey_box().empty()) return better_grey_box();
  if (noted_shift(model_)) return std::string(kMeasureTheValve);
  if (verdict_.beside_ladder) {
    return "as every structure of the ladder was tried, " +
           (fails_any(verdict_, {Kind::nonlinearity}) || !comes_to_rest(model_) ? advice_on_amplitudes()
            : tells_few_parameters() ? "play an input of more tones, which tells more poles apart"
                                     : "try more poles (`eha fit --model io --poles 5 --zeros 4`)");
  }
  return model_.input_map || model_.grey_box ? "fit the other structures too (`eha fit --model ladder`)"
                                             : "try the valve map (--input-map valve)";
}

bool Reasons::is_less_beside_larger_motions() const {
  const auto is_so = [](NonlinearKind kind) {
    return kind == NonlinearKind::motion || kind == NonlinearKind::direction;
  };
  const NonlinearityTest& test = *model_.validation->tests->nonlinearity;
  return is_so(test.kind) || (test.or_kind && is_so(*test.or_kind)) ||
         (test.kind == NonlinearKind::level && test.gain == GainTrend::grows);
}

std::string Reasons::advice_on_amplitudes() const {
  if (const std::string greater = greater_amplitudes(); !greater.empty()) return greater;
  const std::optional<NonlinearKind> kind = nonlinear_kind(model_, verdict_);
  // A rod that integrates has a valve.
  if (!kind) return std::string(kMeasureTheValve);
  const NonlinearityTest& test = *model_.validation->tests->nonlinearity;
  if (is_of_bent_edges(model_, test)) return std::string(kMeasureTheValve);
  if (is_less_beside_larger_motions()) {
    const std::string_view effects = test.kind == NonlinearKind::level ? "dead band and friction" : "friction and play";
    const std::string_view either = test.kind == NonlinearKind::level ? "a dead band or friction" : "friction or play";
    const bool may_be_rate = test.kind == NonlinearKind::direction || test.or_kind == NonlinearKind::direction;
    const auto full = model_.provenance.find(kAtCommandLimit);
    if (full != model_.provenance.end()) {
      return fmt::format("where it is {}, reduce that on the rig, as larger amplitudes have no room: {}", either,
                         full->second);
    }
    return asks_for_smaller_amplitudes()
               ? fmt::format("where it is {}, reduce that on the rig", either)
               : fmt::format("record larger amplitudes, beside which {} are small{}", effects,
                             may_be_rate ? " and a limited rate is great" : " (a limited rate is greater)");
  }
  if (*kind == NonlinearKind::position && !test.or_kind) return "record a smaller travel";
  if (test.gain == GainTrend::falls) {
    return "measure the valve, whose sheet tells a dead band and friction from a saturation (`eha characterise`)";
  }
  return "record smaller amplitudes, where a plant is nearer to linear";
}

std::string Reasons::against_nonlinearity() const {
  const NonlinearityTest& test = *model_.validation->tests->nonlinearity;
  const bool has_map = verdict_.beside_ladder || model_.input_map || model_.grey_box;
  const bool is_of_level = test.kind == NonlinearKind::level && test.gain != GainTrend::falls && !test.or_kind;
  if (is_of_level && !has_map && greater_amplitudes().empty()) return "try the valve map (--input-map valve)";
  const std::string box = better_grey_box().empty() ? std::string() : better_grey_box() + ", or ";
  // Where the rod goes back to a rest.
  const bool is_of_motion = test.kind == NonlinearKind::motion || test.kind == NonlinearKind::direction;
  const bool has_spring = is_of_motion && box.empty() && !model_.grey_box && comes_to_rest(model_);
  return box + advice_on_amplitudes() +
         (has_spring ? "; no structure here has both friction and a rest to which the output returns (a spring): the "
                       "structure friction is of a rod that integrates"
                     : "");
}

std::string Reasons::where_it_matters() const {
  if (!model_.validation) return "where the error does not matter";
  return fmt::format("where an error of {} (rms) does not matter",
                     error_text(std::sqrt(model_.validation->score.mse), model_.output_unit));
}

}  // namespace eha::ident
