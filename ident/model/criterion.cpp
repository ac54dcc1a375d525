// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/criterion.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace eha::ident {
namespace {

using Kind = CriterionKind;
using Unit = CriterionUnit;
using Weight = CriterionWeight;

constexpr auto kKinds = std::to_array<CriterionTraits>({
    {Kind::interpolated, "interpolated_percent", "", Unit::percent, Weight::rejects, "rows interpolated"},
    {Kind::converged, "converged", "", Unit::none, Weight::rejects, "search converged (1: yes)"},
    {Kind::r2, "", "_r2_percent", Unit::percent, Weight::rejects, "R2"},
    {Kind::max_abs_error, "", "_max_abs_error", Unit::output, Weight::rejects, "greatest error"},
    {Kind::residual_input, "residual_input_p", "", Unit::none, Weight::lowers, "the input does not move the error, p"},
    {Kind::residual_whiteness, "residual_whiteness_p", "", Unit::none, Weight::lowers, "the error is plain noise, p"},
    {Kind::nonlinearity, "nonlinearity_p", "", Unit::none, Weight::lowers, "the plant is linear, p"},
    {Kind::future_input, "future_input_p", "", Unit::none, Weight::lowers, "the output does not move the input, p"},
    {Kind::predicted_error, "predicted_error_percent", "", Unit::percent, Weight::lowers,
     "predicted error on a fresh input"},
    {Kind::residual_drift, "residual_drift", "", Unit::output, Weight::lowers, "drift over the validation part"},
    {Kind::input_levels, "input_levels", "", Unit::none, Weight::lowers, "levels of the input"},
    {Kind::saturated, "saturated_percent", "", Unit::percent, Weight::lowers, "rows at an end of the output"},
    {Kind::far_saturated, "far_saturated_percent", "", Unit::percent, Weight::rejects,
     "rows at an end of the output, to reject"},
    {Kind::extrapolated, "extrapolated_percent", "", Unit::percent, Weight::lowers,
     "rows with an input beyond the estimating ones"},
    {Kind::error_over_noise, "error_over_noise", "", Unit::none, Weight::lowers, "error over the measured noise"},
    {Kind::far_error_over_noise, "far_error_over_noise", "", Unit::none, Weight::rejects,
     "error over the measured noise, to reject"},
    {Kind::error_over_refit, "error_over_refit", "", Unit::none, Weight::rejects, "error over that of a refit"},
    {Kind::stability_margin, "stability_margin_rad", "", Unit::radian, Weight::rejects, "stability margin"},
    {Kind::excitation_order, "excitation_order", "", Unit::none, Weight::lowers, "persistent excitation, order"},
    {Kind::order_error, "std_", "", Unit::none, Weight::rejects, "standard error of an order"},
    {Kind::left_out, "left_out_", "", Unit::none, Weight::rejects, "AR-BIC gained by a term"},
    {Kind::coefficient_interval, "interval_", "", Unit::none, Weight::rejects, "distance of the 95 % interval from 0"},
    {Kind::above_recommended, "ar_bic_above_", "", Unit::none, Weight::lowers, "AR-BIC above that of"},
    {Kind::gain_ratio, "gain_ratio", "", Unit::none, Weight::rejects, "valve's gain below the dead band over above"},
    {Kind::other, "", "", Unit::none, Weight::lowers, ""},
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
