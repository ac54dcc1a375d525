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
    return {rounded_to(difference, half_width), fmt::format("{:.2g}", half_width), half_width};
  // A difference of one digit is that of two rounded values no more.
  const auto has_two_digits = [&](double resolution) {
    const std::string text = rounded_to(std::abs(difference), resolution);
    const std::size_t first = text.find_first_of("123456789");
    return first != std::string::npos && text.size() > first + 1;
  };
  double resolution = half_width;
  for (int i = 0; i < kMostDigits; ++i, resolution *= kDigit) {
    const bool is_equal = rounded_to(std::abs(difference), resolution) == rounded_to(half_width, resolution);
    if (!is_equal && (!(std::abs(difference) > 0.0) || has_two_digits(resolution))) break;
  }
  return {rounded_to(difference, resolution), rounded_to(half_width, resolution), resolution};
}

}  // namespace eha::ident
