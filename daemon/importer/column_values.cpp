// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/column_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace eha::importer {
namespace {

/// Steps of a sampled time differ by less than this share of their mean; those at gaps do not.
constexpr double kEvenEnough = 0.5;

}  // namespace

bool counts_rows(const std::vector<double>& values) {
  constexpr double kMostGaps = 0.1;  // of the rows, which a file may lack
  std::size_t gaps = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (std::abs(values[k] - std::round(values[k])) > 0.0) return false;
    if (k == 0) continue;
    const double step = values[k] - values[k - 1];
    if (!(step >= 1.0)) return false;
    if (step > 1.0) ++gaps;
  }
  return values.size() > 1 && static_cast<double>(gaps) <= kMostGaps * static_cast<double>(values.size());
}

bool increases_evenly(const std::vector<double>& values) {
  if (values.size() < 2) return false;
  std::vector<double> steps;
  for (std::size_t k = 1; k < values.size(); ++k) {
    if (!(values[k] > values[k - 1])) return false;
    steps.push_back(values[k] - values[k - 1]);
  }
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const double typical = *middle;
  const auto even = std::count_if(steps.begin(), steps.end(),
                                  [&](double step) { return std::abs(step - typical) <= kEvenEnough * typical; });
  return 10 * even >= 9 * static_cast<std::ptrdiff_t>(steps.size());
}

}  // namespace eha::importer
