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
  for (std::size_t k = 1; k < values.size(); ++k) {
    if (std::abs(values[k] - values[k - 1] - 1.0) > 0.0) return false;
  }
  return values.size() > 1 && std::abs(values[0] - std::round(values[0])) <= 0.0;
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
