// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/missing_codes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace eha::importer {
namespace {

constexpr std::size_t kFewestCodedRows = 60;
constexpr double kBeyondAnything = 1e29;
constexpr double kFarOutside = 3.0;      // distance over the range of the other values
constexpr double kMostCodedShare = 0.5;  // of the rows
constexpr std::size_t kMostCodes = 4;    // of one column

/// 999 and longer, and -999.25 of well logs.
bool has_form_of_code(double value) {
  const double size = std::abs(value);
  if (size >= kBeyondAnything) return true;
  if (size < 999.0 || size > 1e9) return false;
  const double power = std::round(std::log10(size));
  const double short_of = std::pow(10.0, power) - size;
  return std::abs(short_of - 1.0) <= 0.0 || std::abs(size - 999.25) <= 0.0;
}

}  // namespace

std::vector<MissingCode> missing_codes(std::span<const double> values) {
  if (values.size() < kFewestCodedRows) return {};
  std::map<double, std::vector<std::size_t>> found;
  double least = std::numeric_limits<double>::infinity();
  double greatest = -least;
  std::size_t others = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double value = values[k];
    if (!std::isfinite(value)) continue;
    if (has_form_of_code(value)) {
      found[value].push_back(k);
      if (found.size() > kMostCodes) return {};
      continue;
    }
    least = std::min(least, value);
    greatest = std::max(greatest, value);
    ++others;
  }
  const auto wanted = static_cast<std::size_t>((1.0 - kMostCodedShare) * static_cast<double>(values.size()));
  if (found.empty() || others < std::max<std::size_t>(wanted, 2)) return {};
  std::vector<MissingCode> codes;
  for (auto& [value, rows] : found) {
    const double outside = value > greatest ? value - greatest : least - value;
    if (outside > kFarOutside * (greatest - least)) codes.push_back({value, std::move(rows)});
  }
  return codes;
}

std::optional<MissingCode> dropouts(std::span<const double> values) {
  constexpr std::size_t kFewestInARow = 4;
  constexpr double kBeyondOthers = 3.0;
  const auto is_zero = [&](std::size_t k) { return !(std::abs(values[k]) > 0.0); };
  double least_edge = std::numeric_limits<double>::infinity();
  double greatest_other = 0.0;
  MissingCode found;
  for (std::size_t k = 0; k < values.size();) {
    std::size_t end = k + 1;
    if (is_zero(k)) {
      while (end < values.size() && is_zero(end)) ++end;
    }
    const bool is_drop = is_zero(k) && end - k >= kFewestInARow && k > 0 && end < values.size();
    if (is_drop) {
      least_edge = std::min({least_edge, std::abs(values[k - 1]), std::abs(values[end])});
      for (std::size_t row = k; row < end; ++row) found.rows.push_back(row);
      ++found.dropouts;
      // The step out of it is none of the others.
      k = end + 1;
      continue;
    }
    if (k > 0 && std::isfinite(values[k] - values[k - 1])) {
      const bool is_into_drop = is_zero(k) && end - k >= kFewestInARow;
      if (!is_into_drop) greatest_other = std::max(greatest_other, std::abs(values[k] - values[k - 1]));
    }
    k = end;
  }
  const bool stands_out = std::isfinite(least_edge) && least_edge > kBeyondOthers * greatest_other;
  if (found.rows.empty() || 2 * found.rows.size() >= values.size() || !stands_out) return std::nullopt;
  return found;
}

std::string missing_code_text(const MissingCode& code, const std::string& column) {
  const std::size_t count = code.rows.size();
  if (code.dropouts > 0) {
    return fmt::format(
        "{} drops to 0 and comes back within a row in {} place{}, {} rows in all, as where a contact is loose or a "
        "signal is lost",
        column, code.dropouts, code.dropouts == 1 ? "" : "s", count);
  }
  return fmt::format("{} row{} of {} hold{} {:.6g}, a code for missing values", count, count == 1 ? "" : "s", column,
                     count == 1 ? "s" : "", code.value);
}

}  // namespace eha::importer
