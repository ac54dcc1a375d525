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

std::string missing_code_text(const MissingCode& code, const std::string& column) {
  const std::size_t count = code.rows.size();
  return fmt::format("{} row{} of {} hold{} {:.6g}, a code for missing values", count, count == 1 ? "" : "s", column,
                     count == 1 ? "s" : "", code.value);
}

}  // namespace eha::importer
