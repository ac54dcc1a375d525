// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/option_values.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <system_error>

#include "ident/model/model.hpp"

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

CLI::Validator ends_in(std::vector<std::string> endings) {
  return CLI::Validator(
      [endings = std::move(endings)](std::string& name) {
        const std::string ending = std::filesystem::path(name).extension().string();
        const bool known = std::find(endings.begin(), endings.end(), ending) != endings.end();
        return known ? std::string()
                     : fmt::format("expected a name that ends in {}, got {}", fmt::join(endings, " or "), name);
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
