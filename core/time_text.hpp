// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace eha {

/// A time of a record [s] in six digits or more, from 1000 s on to the millisecond: times may be those of a clock that
/// began in 1970.
[[nodiscard]] inline std::string time_text(double time_s, int digits = 6) {
  constexpr double kToTheMillisecond_s = 1000.0;
  if (!(std::abs(time_s) >= kToTheMillisecond_s)) return fmt::format("{:.{}g}", time_s, digits);
  std::string text = fmt::format("{:.3f}", time_s);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

}  // namespace eha
