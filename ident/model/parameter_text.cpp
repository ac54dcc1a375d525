// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/parameter_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace eha::ident {

std::string error_figure(double error) { return fmt::format("{:.3g}", error); }

double half_width95(const ParameterEstimate& parameter) {
  return parameter.fixed ? 0.0 : 0.5 * (parameter.upper95 - parameter.lower95);
}

std::string with_interval(const ParameterEstimate& parameter, std::string_view sign) {
  // The paper's procedure gives no standard errors.
  if (parameter.fixed || std::abs(parameter.std) <= 0.0) return fmt::format("{:.6g}", parameter.value);
  return with_half_width(parameter.value, half_width95(parameter), sign);
}

std::string rounded_to(double value, double half_width) {
  if (!(half_width > 0.0 && std::isfinite(half_width))) return fmt::format("{:.4g}", value);
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(half_width))), 0, 9);
  const std::string text = fmt::format("{:.{}f}", value, decimals);
  return text.find_first_of("123456789") == std::string::npos && text.starts_with('-') ? text.substr(1) : text;
}

std::string with_half_width(double value, double half_width, std::string_view sign) {
  if (!(half_width > 0.0) || !std::isfinite(half_width)) return fmt::format("{:.4g} {} ?", value, sign);
  if (half_width > std::abs(value)) return fmt::format("{:.3g} {} {:.2g}", value, sign, half_width);
  return fmt::format("{} {} {}", rounded_to(value, half_width), sign, rounded_to(half_width, half_width));
}

}  // namespace eha::ident
