// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/value_step.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "ident/statistics/robust.hpp"

namespace eha::ident {
namespace {

constexpr std::size_t kFewestRows = 20;
constexpr std::size_t kFewestValues = 3;
constexpr std::size_t kRowsAValue = 5;
constexpr std::size_t kLookedAt = 4096;  // rows that show whether there are too many values
constexpr double kSame = 1e-9;           // of the range: less is the conversion of decimals
constexpr double kOnGrid = 0.02;         // of a step

/// Whether some of the rows have too many values for a coarse signal already: sorting all of them is not needed.
bool has_many_values(const std::vector<double>& values, double same, std::size_t most) {
  std::vector<double> some;
  for (std::size_t k = 0; k < values.size(); k += 1 + values.size() / kLookedAt) some.push_back(values[k]);
  std::sort(some.begin(), some.end());
  std::size_t apart = 0;
  for (std::size_t k = 1; k < some.size(); ++k) apart += some[k] - some[k - 1] > same ? 1 : 0;
  return apart >= most;
}

}  // namespace

double value_step(std::span<const double> values, std::size_t most_values) {
  if (values.size() < kFewestRows) return 0.0;
  std::vector<double> sorted;
  std::copy_if(values.begin(), values.end(), std::back_inserter(sorted), [](double x) { return std::isfinite(x); });
  if (sorted.empty()) return 0.0;
  const auto [lowest, highest] = std::minmax_element(sorted.begin(), sorted.end());
  const double same = kSame * (*highest - *lowest);
  if (has_many_values(sorted, same, most_values)) return 0.0;
  std::sort(sorted.begin(), sorted.end());
  std::vector<double> apart;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < sorted.size(); ++k) {
    const double difference = sorted[k] - sorted[k - 1];
    if (difference <= same) continue;
    apart.push_back(difference);
    least = std::min(least, difference);
    if (apart.size() >= most_values) return 0.0;
  }
  const std::size_t count = apart.size() + 1;
  if (count < kFewestValues || kRowsAValue * count > sorted.size()) return 0.0;
  const bool is_grid = std::all_of(apart.begin(), apart.end(), [&](double difference) {
    const double steps = difference / least;
    return std::abs(steps - std::round(steps)) <= kOnGrid;
  });
  return is_grid ? least : 0.0;
}

bool moves_by_single_steps(std::span<const double> values) {
  constexpr double kMostSteps = 3.5;
  const double step = value_step(values);
  if (!(step > 0.0)) return false;
  std::vector<double> moves;
  for (std::size_t k = 1; k < values.size(); ++k) {
    const double move = std::abs(values[k] - values[k - 1]);
    if (move > kOnGrid * step) moves.push_back(move);
  }
  return !moves.empty() && median_of(std::move(moves)) <= kMostSteps * step;
}

}  // namespace eha::ident
