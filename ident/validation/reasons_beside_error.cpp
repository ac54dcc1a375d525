// SPDX-License-Identifier: GPL-3.0-or-later
// What a verdict says beside the error: what was not judged, stability, parameters.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "ident/fractional/stability.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/search/least_squares.hpp"
#include "ident/validation/reasons.hpp"
#include "ident/validation/slow_pair.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident {
namespace {

using Kind = CriterionKind;

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

}  // namespace

std::string Reasons::undetermined_order(const Criterion& c) const {
  const ParameterEstimate* p = find(c.parameter);
  const double half_width = std::max(kInterval95 * c.value, p == nullptr ? 0.0 : half_width95(*p));
  const std::string value = p == nullptr ? c.parameter : fmt::format("{} = {:.3g}", c.parameter, p->value);
  return fmt::format(
      "The record hardly determines the order {}: its 95 % interval is +- {:.2g}, more than +- {:.2g}; use a model "
      "of fewer parameters, or record longer.",
      value, half_width, kInterval95 * c.limit);
}

std::string Reasons::not_judged(const Criterion& c) const {
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

std::string Reasons::lacks_power() const {
  const std::size_t all = model_.validation->score.samples;
  const std::size_t answering = answering_samples(*model_.validation);
  const std::string miss = fmt::format(
      "the test would more likely miss than detect what makes {:.0f} % of the residual's power", 100.0 * kNoticedShare);
  if (2 * answering > all) return fmt::format("with {} validating samples {}; record longer", all, miss);
  return fmt::format(
      "within 20 samples the input covers 2 % of its range for only {} of the {} validating ones, with which {}; "
      "compare fewer rows of so slow a motion (--decimate 10), play an input that moves more often (a multisine), or "
      "record longer",
      answering, all, miss);
}

bool Reasons::is_judged(Kind kind) const {
  return std::none_of(verdict_.criteria.begin(), verdict_.criteria.end(),
                      [&](const Criterion& c) { return c.kind == kind && !c.judged; });
}

bool Reasons::passes_the_rest() const {
  return std::all_of(verdict_.criteria.begin(), verdict_.criteria.end(),
                     [](const Criterion& c) { return c.passed || c.kind == Kind::input_levels; });
}

std::string Reasons::unstable(const Criterion& c) const {
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

void Reasons::note_flat_ridge() {
  if (!model_.estimation || !model_.estimation->converged) return;
  if (model_.estimation->termination != text(Termination::flat_ridge)) return;
  const auto& known = model_.estimation->correlation;
  const std::string names =
      known && !known->indistinguishable.empty() ? fmt::format(" ({})", fmt::join(known->indistinguishable, ", ")) : "";
  notes_.push_back(
      fmt::format("Several parameters{} compensate each other: the cost is flat along a ridge, and the output hardly "
                  "changes; use the model as a whole, no single value of it, or record longer.",
                  names));
}

void Reasons::note_low_r2() {
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

void Reasons::note_allowed_instability() {
  const bool allowed = std::any_of(verdict_.criteria.begin(), verdict_.criteria.end(),
                                   [](const Criterion& c) { return c.kind == Kind::stability_margin && c.passed; });
  if (!allowed || !model_.stability || model_.stability->stable) return;
  notes_.push_back(
      fmt::format("The model is unstable (test: {}, margin {:.4g} rad), which the limits allow; simulate "
                  "it no longer than the record, or within a closed loop.",
                  model_.stability->test, model_.stability->margin_rad));
}

void Reasons::note_wide_intervals() {
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

void Reasons::note_cancelling_pair() {
  if (!rejections_.empty() || takes_in_a_drift(verdict_)) return;
  if (std::string sentence = cancelling_sentence(model_); !sentence.empty()) notes_.push_back(std::move(sentence));
}

const ParameterEstimate* Reasons::find(const std::string& name) const {
  const auto at = std::find_if(model_.parameters.begin(), model_.parameters.end(),
                               [&](const ParameterEstimate& p) { return p.name == name; });
  return at == model_.parameters.end() ? nullptr : &*at;
}

std::string Reasons::estimate(const std::string& name) const {
  const ParameterEstimate* p = find(name);
  return p == nullptr ? name : fmt::format("{} = {}", name, with_interval(*p));
}

}  // namespace eha::ident
