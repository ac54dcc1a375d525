// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/frozen_input.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ident/signal/kept_values.hpp"
#include "ident/statistics/robust.hpp"

namespace eha::ident {
namespace {

using Eigen::Index;
using Rows = std::pair<Index, Index>;  // first and last

constexpr Index kFewestToFreeze = 200;
constexpr Index kShortestFrozen = 30;
constexpr double kFrozenShare = 0.01;    // of the rows
constexpr double kMostKeptBeside = 0.1;  // of the rows beside
constexpr double kLongHold = 0.1;        // of the rows
constexpr Index kTimesOtherHolds = 5;    // of the longest other one
constexpr Index kPartsOfStay = 6;        // of the shortest stretch; the first one holds the answer to what was before
constexpr Index kPartsOfRecord = 50;
constexpr Index kFewestOfWindow = 10;
constexpr std::size_t kFewestElsewhere = 8;  // windows
constexpr double kBendOverNoise = 5.0;
constexpr double kTurnsAsElsewhere = 0.4;

/// Rms of rows about a straight line through them.
double bend(const Eigen::VectorXd& values, Index first, Index count) {
  const double middle = 0.5 * static_cast<double>(count - 1);
  double mean = 0.0;
  double slope = 0.0;
  double power = 0.0;
  for (Index k = 0; k < count; ++k) mean += values[first + k] / static_cast<double>(count);
  for (Index k = 0; k < count; ++k) {
    const double at = static_cast<double>(k) - middle;
    slope += at * values[first + k];
    power += at * at;
  }
  slope /= power;
  double left = 0.0;
  for (Index k = 0; k < count; ++k) {
    const double e = values[first + k] - mean - slope * (static_cast<double>(k) - middle);
    left += e * e;
  }
  return std::sqrt(left / static_cast<double>(count));
}

/// Standard deviation of white noise on a smooth signal, by the third differences of its rows.
double noise_of(const Eigen::VectorXd& values) {
  constexpr double kOfThirdDifferences = 20.0;  // 1 + 9 + 9 + 1
  double sum = 0.0;
  for (Index k = 3; k < values.size(); ++k) {
    const double d = values[k] - 3.0 * values[k - 1] + 3.0 * values[k - 2] - values[k - 3];
    sum += d * d;
  }
  return std::sqrt(sum / kOfThirdDifferences / static_cast<double>(values.size() - 3));
}

/// Bend of each window of such a length within these rows.
std::vector<double> bends(const Eigen::VectorXd& output, Index first, Index behind, Index window) {
  std::vector<double> found;
  for (Index k = first; k + window <= behind; k += window) found.push_back(bend(output, k, window));
  return found;
}

/// Of an input that is held, as steps are: a value that is kept far longer than every other one; none without it.
std::vector<Rows> longest_hold(const Eigen::VectorXd& input) {
  Rows longest{0, -1};
  Index second = 0;
  each_kept_value(input, [&](Index first, Index last) {
    const Index length = longest.second - longest.first + 1;
    if (last - first + 1 <= length) {
      second = std::max(second, last - first + 1);
      return;
    }
    second = std::max(second, length);
    longest = {first, last};
  });
  const Index length = longest.second - longest.first + 1;
  if (static_cast<double>(length) < kLongHold * static_cast<double>(input.size())) return {};
  if (length < kTimesOtherHolds * second) return {};
  return {longest};
}

}  // namespace

std::vector<Rows> frozen_input(const Eigen::VectorXd& input, const Eigen::VectorXd& output) {
  const Index rows = input.size();
  if (rows < kFewestToFreeze || output.size() != rows) return {};
  if (!input.allFinite() || !output.allFinite()) return {};
  const double least = input.minCoeff();
  const double greatest = input.maxCoeff();
  const auto shortest = std::max(kShortestFrozen, static_cast<Index>(kFrozenShare * static_cast<double>(rows)));
  std::vector<Rows> kept;
  Index repeats = 0;
  Index in_kept = 0;
  each_kept_value(input, [&](Index first, Index last) {
    // At an end it may be clipped, which is another fault.
    if (last - first + 1 >= shortest && input[first] > least && input[first] < greatest) {
      kept.emplace_back(first, last);
      in_kept += last - first + 1;
    } else {
      repeats += last - first;
    }
  });
  const bool moves_with_each_row =
      !kept.empty() && static_cast<double>(repeats) <= kMostKeptBeside * static_cast<double>(rows - in_kept);
  if (!moves_with_each_row) kept = longest_hold(input);
  const double noise = noise_of(output);
  std::vector<Rows> found;
  for (const Rows& stretch : kept) {
    const Index window =
        std::max(kFewestOfWindow, std::min(rows / kPartsOfRecord, (stretch.second - stretch.first + 1) / kPartsOfStay));
    std::vector<double> elsewhere;
    Index begin = 0;
    for (const auto& [first, last] : kept) {
      const std::vector<double> more = bends(output, begin, first, window);
      elsewhere.insert(elsewhere.end(), more.begin(), more.end());
      begin = last + 1;
    }
    const std::vector<double> more = bends(output, begin, rows, window);
    elsewhere.insert(elsewhere.end(), more.begin(), more.end());
    const std::vector<double> within = bends(output, stretch.first + window, stretch.second + 1, window);
    if (within.size() < 2) continue;
    if (elsewhere.size() < kFewestElsewhere) continue;
    const double usual = median_of(std::move(elsewhere));
    const double here = median_of(within);
    if (usual > kBendOverNoise * noise && here > kBendOverNoise * noise && here > kTurnsAsElsewhere * usual) {
      found.push_back(stretch);
    }
  }
  return found;
}

}  // namespace eha::ident
