// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/option_values.hpp"

#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>

namespace eha::cli {
namespace {

std::optional<double> number(const std::string& text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

}  // namespace

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

ident::FrequencyInterval band_of(const std::string& text) {
  const std::size_t colon = text.find(':');
  const auto low = number(text.substr(0, colon));
  const auto high = colon == std::string::npos ? std::nullopt : number(text.substr(colon + 1));
  if (!low || !high || !(*low > 0.0 && *low < *high && *high / *low <= 1e8)) {
    throw CLI::ValidationError("--band", "expected LOW:HIGH in Hz with 0 < LOW < HIGH, got " + text);
  }
  return {*low, *high};
}

}  // namespace eha::cli
