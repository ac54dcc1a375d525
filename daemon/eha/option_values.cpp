// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/option_values.hpp"

#include <charconv>
#include <cmath>
#include <system_error>

namespace eha::cli {

CLI::Validator finite_number(const std::string& range, bool (*accept)(double)) {
  return CLI::Validator(
      [range, accept](std::string& text) {
        double value = 0.0;
        const char* const end = text.data() + text.size();
        const auto [stop, error] = std::from_chars(text.data(), end, value);
        if (error != std::errc() || stop != end || !std::isfinite(value) || !accept(value)) {
          return "expected " + range + ", got " + text;
        }
        return std::string();
      },
      "");
}

}  // namespace eha::cli
