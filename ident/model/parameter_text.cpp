// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/parameter_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace eha::ident {

double half_width95(const ParameterEstimate& parameter) {
  return parameter.fixed ? 0.0 : 0.5 * (parameter.upper95 - parameter.lower95);
}

std::string with_interval(const ParameterEstimate& parameter, std::string_view sign) {
  // The paper's procedure gives no standard errors.
  if (parameter.fixed || std::abs(parameter.std) <= 0.0) return fmt::format("{:.6g}", parameter.value);
  return with_half_width(parameter.value, half_width95(parameter), sign);
}

std::string with_half_width(double value, double half_width, std::string_view sign) {
  if (!(half_width > 0.0) || !std::isfinite(half_width)) return fmt::format("{:.4g} {} ?", value, sign);
  if (half_width > std::abs(value)) return fmt::format("{:.3g} {} {:.2g}", value, sign, half_width);
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(half_width))), 0, 9);
  return fmt::format("{:.{}f} {} {:.{}f}", value, decimals, sign, half_width, decimals);
}

}  // namespace eha::ident
