// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cctype>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "core/display_unit.hpp"
#include "core/inch.hpp"
#include "core/unit_names.hpp"

namespace eha::cli {

/// Converts a length with its unit, "2.95in" or "+5 mm", to inches; none if the text is not one.
[[nodiscard]] inline std::optional<double> inches_of(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  const std::string written = known_unit(text).value_or("");
  for (const LengthUnit& unit : kLengthUnits) {
    if (unit.name == written) return value * unit.metres / kMetrePerInch;
  }
  return std::nullopt;
}

/// The same, but also for a number without a unit, which is then in `unit`.
[[nodiscard]] inline std::optional<double> inches_of(std::string_view text, const DisplayUnit& unit) {
  while (text.ends_with(' ')) text.remove_suffix(1);
  const bool is_alone =
      !text.empty() && (std::isdigit(static_cast<unsigned char>(text.back())) != 0 || text.back() == '.');
  return inches_of(is_alone ? std::string(text) + unit.of("in") : std::string(text));
}

/// "74,989mm" with a point for its decimal comma; a text with more commas, or with a point too, as it is. For readings
/// of a ruler and a meter alone, which are checked against the rig: what commands a motion takes points.
[[nodiscard]] inline std::string with_decimal_point(std::string_view text) {
  std::string point(text);
  const std::size_t comma = point.find(',');
  const auto is_digit = [&](std::size_t at) {
    return at < point.size() && std::isdigit(static_cast<unsigned char>(point[at])) != 0;
  };
  if (comma == std::string::npos || comma == 0 || !is_digit(comma - 1) || !is_digit(comma + 1)) return point;
  if (point.find(',', comma + 1) != std::string::npos || point.find('.') != std::string::npos) return point;
  point[comma] = '.';
  return point;
}

/// Returns the unit of a length that inches_of() takes, "mm" of "2.5 mm"; empty without one.
[[nodiscard]] inline std::string unit_of_length(std::string_view text) {
  const std::size_t end = text.find_last_of("0123456789., ");
  text.remove_prefix(end == std::string_view::npos ? 0 : end + 1);
  const std::string unit = known_unit(text).value_or("");
  return is_length(unit) ? unit : std::string();
}

}  // namespace eha::cli
