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
    {Kind::interpolated, "interpolated_percent", "", Unit::percent, Weight::rejects},
    {Kind::converged, "converged", "", Unit::none, Weight::rejects},
    {Kind::r2, "", "_r2_percent", Unit::percent, Weight::rejects},
    {Kind::max_abs_error, "", "_max_abs_error", Unit::output, Weight::rejects},
    {Kind::residual_input, "residual_input_p", "", Unit::none, Weight::lowers},
    {Kind::residual_whiteness, "residual_whiteness_p", "", Unit::none, Weight::lowers},
    {Kind::nonlinearity, "nonlinearity_p", "", Unit::none, Weight::lowers},
    {Kind::future_input, "future_input_p", "", Unit::none, Weight::lowers},
    {Kind::predicted_error, "predicted_error_percent", "", Unit::percent, Weight::lowers},
    {Kind::residual_drift, "residual_drift", "", Unit::output, Weight::lowers},
    {Kind::input_levels, "input_levels", "", Unit::none, Weight::lowers},
    {Kind::saturated, "saturated_percent", "", Unit::percent, Weight::lowers},
    {Kind::extrapolated, "extrapolated_percent", "", Unit::percent, Weight::lowers},
    {Kind::error_over_noise, "error_over_noise", "", Unit::none, Weight::lowers},
    {Kind::far_error_over_noise, "far_error_over_noise", "", Unit::none, Weight::rejects},
    {Kind::error_over_refit, "error_over_refit", "", Unit::none, Weight::rejects},
    {Kind::stability_margin, "stability_margin_rad", "", Unit::radian, Weight::rejects},
    {Kind::excitation_order, "excitation_order", "", Unit::none, Weight::lowers},
    {Kind::order_error, "std_", "", Unit::none, Weight::rejects},
    {Kind::left_out, "left_out_", "", Unit::none, Weight::rejects},
    {Kind::coefficient_interval, "interval_", "", Unit::none, Weight::rejects},
    {Kind::other, "", "", Unit::none, Weight::lowers},
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
         kind == Kind::coefficient_interval || kind == Kind::other;
}

}  // namespace

std::span<const CriterionTraits> criterion_kinds() { return kKinds; }

const CriterionTraits& traits_of(CriterionKind kind) { return kKinds[static_cast<std::size_t>(kind)]; }

std::string name_of(const Criterion& criterion) {
  const CriterionTraits& traits = traits_of(criterion.kind);
  return std::string(traits.prefix) + criterion.parameter + std::string(traits.suffix);
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
