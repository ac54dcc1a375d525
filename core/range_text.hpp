// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "core/keys.hpp"

namespace eha {

/// "a number from 0 to 1"
[[nodiscard]] inline std::string describe(const Range& range) {
  const bool bounded_below = std::isfinite(range.low);
  const bool bounded_above = std::isfinite(range.high);
  if (bounded_below && bounded_above && !range.low_excluded && !range.high_excluded) {
    return fmt::format("a number from {:.6g} to {:.6g}", range.low, range.high);
  }
  std::string text = "a finite number";
  if (bounded_below) text = fmt::format("a number {} {:.6g}", range.low_excluded ? "above" : "of at least", range.low);
  if (bounded_above) {
    text += fmt::format("{} {} {:.6g}", bounded_below ? " and" : "", range.high_excluded ? "below" : "of at most",
                        range.high);
  }
  return text;
}

/// "an integer from 3 to 1000"
[[nodiscard]] inline std::string describe_integers(std::int64_t low, std::int64_t high) {
  if (low == high) return fmt::format("{}", low);
  if (high == std::numeric_limits<std::int64_t>::max()) return fmt::format("an integer of at least {}", low);
  return fmt::format("an integer from {} to {}", low, high);
}

}  // namespace eha
