// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/parameter_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace eha::ident {

std::string error_figure(double error) { return fmt::format("{:.3g}", error); }

std::string figure_text(double figure) {
  const double size = std::abs(figure);
  if (!(size >= 99.5) || size >= 1e5) return fmt::format("{:.2g}", figure);
  const double digit = size < 1e3 ? 10.0 : size < 1e4 ? 100.0 : 1000.0;  // the last of two
  return fmt::format("{:.0f}", digit * std::round(figure / digit));
}

std::string percent_text(double percent, int decimals) {
  const double step = std::pow(10.0, -decimals);
  if (percent < 100.0 && percent >= 100.0 - 0.5 * step) return fmt::format("above {:.{}f}", 100.0 - step, decimals);
  return fmt::format("{:.{}f}", percent, decimals);
}

double covariance(const Model& model, const ParameterEstimate& a, const ParameterEstimate& b) {
  if (a.fixed || b.fixed || !std::isfinite(a.std) || !std::isfinite(b.std)) return 0.0;
  if (a.name == b.name) return a.std * b.std;
  if (!model.estimation || !model.estimation->correlation) return 0.0;
  const ParameterCorrelation& known = *model.estimation->correlation;
  const auto index = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(known.names.begin(), known.names.end(), name) - known.names.begin());
  };
  const std::size_t i = index(a.name);
  const std::size_t k = index(b.name);
  return i < known.matrix.size() && k < known.matrix[i].size() ? known.matrix[i][k] * a.std * b.std : 0.0;
}

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
