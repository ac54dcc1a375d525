// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace eha::config {

/// Three digits of a promised bound, rounded to the side on which nothing is promised that is not held. The same on
/// every page and table, so that one bound is one number.
[[nodiscard]] inline std::string bound_text(double bound, bool is_upper) {
  constexpr double kRounding = 1e-9;  // of the last digit
  if (!(std::abs(bound) > 0.0) || !std::isfinite(bound)) return fmt::format("{:g}", bound);
  const double digit = std::pow(10.0, std::floor(std::log10(std::abs(bound))) - 2.0);
  const double digits = is_upper ? std::ceil(bound / digit - kRounding) : std::floor(bound / digit + kRounding);
  return fmt::format("{:.4g}", digit * digits);
}

/// "0.00321" of 0.003206.
[[nodiscard]] inline std::string upper_bound_text(double bound) { return bound_text(bound, true); }
/// "68.9" of 68.97.
[[nodiscard]] inline std::string lower_bound_text(double bound) { return bound_text(bound, false); }

}  // namespace eha::config
