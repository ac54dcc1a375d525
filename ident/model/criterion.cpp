// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/criterion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

namespace eha::ident {
namespace {

using Kind = CriterionKind;
using Unit = CriterionUnit;
using Weight = CriterionWeight;

constexpr auto kKinds = std::to_array<CriterionTraits>({
    {Kind::interpolated, "interpolated_percent", "", Unit::percent, Weight::rejects, "rows interpolated in gaps",
     "rows missing in gaps"},
    {Kind::unmeasured, "unmeasured_percent", "", Unit::percent, Weight::rejects, "rows not measured, left out",
     "too few rows measured"},
    {Kind::converged, "converged", "", Unit::none, Weight::rejects, "search converged (1: yes)",
     "search did not converge"},
    {Kind::r2, "", "_r2_percent", Unit::percent, Weight::rejects, "R2", "R2 too low"},
    {Kind::max_abs_error, "", "_max_abs_error", Unit::output, Weight::rejects, "greatest error", "one error too large"},
    {Kind::input_noise, "input_noise_percent", "", Unit::percent, Weight::lowers,
     "share of the error that noise of the measured input makes", "the measured input is noisy"},
    {Kind::between_rows, "between_rows_percent", "", Unit::percent, Weight::lowers,
     "what curves between the rows change, over the error", "rows too coarse for the input"},
    {Kind::residual_input, "residual_input_p", "", Unit::none, Weight::lowers, "the input does not move the error, p",
     "the input moves the error"},
    {Kind::residual_whiteness, "residual_whiteness_p", "", Unit::none, Weight::lowers,
     "the error is noise of a steady kind, p", "the error is no noise of a steady kind"},
    {Kind::nonlinearity, "nonlinearity_p", "", Unit::none, Weight::lowers, "the plant is linear, p",
     "plant not linear"},
    {Kind::future_input, "future_input_p", "", Unit::none, Weight::lowers, "the output does not move the input, p",
     "loop closed"},
    {Kind::predicted_error, "predicted_error_percent", "", Unit::percent, Weight::lowers,
     "predicted error on a fresh input", "not exact on a fresh input"},
    {Kind::residual_drift, "residual_drift", "", Unit::output, Weight::lowers, "drift over the validation part",
     "the error drifts"},
    {Kind::slow_pair, "slow_pair", "", Unit::none, Weight::lowers, "zero and pole slower than the record",
     "a drift taken for the plant"},
    {Kind::fast_resonance, "fast_resonance_Hz", "", Unit::none, Weight::lowers, "resonance that the rows show, Hz",
     "the resonance may be a faster one"},
    {Kind::input_levels, "input_levels", "", Unit::none, Weight::lowers, "levels of the input",
     "too few levels of the input"},
    {Kind::saturated, "saturated_percent", "", Unit::percent, Weight::lowers, "rows at an end of the output",
     "output at an end"},
    {Kind::far_saturated, "far_saturated_percent", "", Unit::percent, Weight::rejects,
     "rows at an end of the output, to reject", "output long at an end"},
    {Kind::jump, "error_jump", "", Unit::output, Weight::lowers, "sudden change of the error", "the error jumps"},
    {Kind::far_jump, "far_error_jump", "", Unit::output, Weight::rejects,
     "sudden change of the error where it estimates, to reject", "the error jumps"},
    {Kind::extrapolated, "extrapolated_percent", "", Unit::percent, Weight::lowers,
     "rows with an input beyond the estimating ones", "input beyond the estimating part"},
    {Kind::wrong_input, "wrong_input", "", Unit::none, Weight::rejects, "input column is wrong (1: yes)",
     "input column is wrong"},
    {Kind::error_over_noise, "error_over_noise", "", Unit::none, Weight::lowers, "error over the measured noise",
     "error {value} times the noise"},
    {Kind::far_error_over_noise, "far_error_over_noise", "", Unit::none, Weight::rejects,
     "error over the measured noise, to reject", "error {value} times the noise"},
    {Kind::error_over_refit, "error_over_refit", "", Unit::none, Weight::rejects, "error over that of a refit",
     "of another plant"},
    {Kind::error_over_estimating, "error_over_estimating", "", Unit::none, Weight::lowers,
     "error over that of the estimating part", "unseen error {value} times the estimating one"},
    {Kind::record_length, "record_length_s", "", Unit::none, Weight::rejects, "length of the record, s",
     "record too short to judge"},
    {Kind::stability_margin, "stability_margin_rad", "", Unit::radian, Weight::rejects, "stability margin",
     "not stable enough"},
    {Kind::excitation_order, "excitation_order", "", Unit::none, Weight::lowers, "persistent excitation, order",
     "input too simple"},
    {Kind::order_error, "std_", "", Unit::none, Weight::rejects, "standard error of an order",
     "order {parameter} not known"},
    {Kind::left_out, "left_out_", "", Unit::none, Weight::rejects, "AR-BIC gained by a term", "no need of {parameter}"},
    {Kind::coefficient_interval, "interval_", "", Unit::none, Weight::rejects, "distance of the 95 % interval from 0",
     "{parameter} may be 0"},
    {Kind::above_recommended, "ar_bic_above_", "", Unit::none, Weight::lowers, "AR-BIC above that of",
     "{parameter} clearly better"},
    {Kind::gain_ratio, "gain_ratio", "", Unit::none, Weight::rejects, "valve's gain below the dead band over above",
     "map is no valve's"},
    {Kind::other, "", "", Unit::none, Weight::lowers, "", ""},
});

constexpr bool are_in_order() {
  for (std::size_t k = 0; k < kKinds.size(); ++k) {
    if (static_cast<std::size_t>(kKinds[k].kind) != k) return false;
  }
  return true;
}
static_assert(are_in_order());

constexpr bool has_parameter(Kind kind) {
  return kind == Kind::r2 || kind == Kind::max_abs_error || kind == Kind::order_error || kind == Kind::left_out ||
         kind == Kind::coefficient_interval || kind == Kind::above_recommended || kind == Kind::other;
}

}  // namespace

std::span<const CriterionTraits> criterion_kinds() { return kKinds; }

const CriterionTraits& traits_of(CriterionKind kind) { return kKinds[static_cast<std::size_t>(kind)]; }

std::string name_of(const Criterion& criterion) {
  const CriterionTraits& traits = traits_of(criterion.kind);
  return std::string(traits.prefix) + criterion.parameter + std::string(traits.suffix);
}

std::string words_of(const Criterion& criterion) {
  const std::string_view words = traits_of(criterion.kind).words;
  if (words.empty()) return criterion.parameter;
  return std::string(words) + (criterion.parameter.empty() ? "" : ", " + criterion.parameter);
}

std::string note_of(const Criterion& criterion) {
  const std::string_view note = traits_of(criterion.kind).note;
  if (note.empty()) return words_of(criterion);
  return fmt::format(fmt::runtime(note), fmt::arg("parameter", criterion.parameter),
                     fmt::arg("value", fmt::format("{:.2g}", criterion.value)));
}

Criterion criterion_named(std::string_view name) {
  const auto found = std::find_if(kKinds.begin(), kKinds.end(), [&](const CriterionTraits& traits) {
    if (!has_parameter(traits.kind)) return name == traits.prefix;
    return name.size() >= traits.prefix.size() + traits.suffix.size() && name.starts_with(traits.prefix) &&
           name.ends_with(traits.suffix);
  });
  name.remove_prefix(found->prefix.size());
  name.remove_suffix(found->suffix.size());
  return {.kind = found->kind, .parameter = std::string(name)};
}

}  // namespace eha::ident
