// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/difference_text.hpp"

#include <fmt/format.h>

#include <cmath>

#include "ident/model/parameter_text.hpp"

namespace eha::ident {

DifferenceText difference_text(double difference, double half_width) {
  constexpr double kDigit = 0.1;
  constexpr int kMostDigits = 3;  // more than those of the half width
  if (!(half_width > 0.0 && std::isfinite(half_width)))
    return {rounded_to(difference, half_width), fmt::format("{:.2g}", half_width)};
  double resolution = half_width;
  for (int i = 0; i < kMostDigits; ++i, resolution *= kDigit) {
    if (rounded_to(std::abs(difference), resolution) != rounded_to(half_width, resolution)) break;
  }
  return {rounded_to(difference, resolution), rounded_to(half_width, resolution)};
}

}  // namespace eha::ident
