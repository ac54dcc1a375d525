// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/clipped_input.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "ident/signal/kept_values.hpp"

namespace eha::ident {
namespace {

using Eigen::Index;

constexpr Index kFewestClippedRows = 60;
constexpr Index kShortestClip = 3;
constexpr double kLeastClippedShare = 0.02;  // of the rows
constexpr double kMostRepeatsBeside = 0.1;   // of the rows beside the runs
constexpr double kGreatestMove = 0.25;       // of the range, from row to row: beyond it the input jumps
constexpr Index kSlopeRows = 3;

constexpr std::size_t kFewestHolds = 20;
constexpr std::size_t kFewestHoldsAtEnd = 3;
constexpr double kLeastAtEnd = 0.1;     // of the holds, or of the rows
constexpr double kLeastDistinct = 0.9;  // of the levels elsewhere

struct Ends {
  double least = 0.0;
  double greatest = 0.0;
};

/// None of a constant input or one of few rows.
std::optional<Ends> ends_of(const Eigen::VectorXd& input) {
  if (input.size() < kFewestClippedRows || !input.allFinite()) return std::nullopt;
  const Ends ends{input.minCoeff(), input.maxCoeff()};
  return ends.least < ends.greatest ? std::optional(ends) : std::nullopt;
}

}  // namespace

std::optional<ClippedInput> clipped_levels(const Eigen::VectorXd& input) {
  const std::optional<Ends> ends = ends_of(input);
  if (!ends) return std::nullopt;
  const auto [least, greatest] = *ends;
  const Index rows = input.size();
  ClippedInput found;
  std::vector<double> elsewhere;
  std::size_t at_greatest = 0;
  std::size_t at_least = 0;
  Index clipped = 0;
  each_kept_value(input, [&](Index first, Index last) {
    const double value = input[first];
    const bool is_greatest = is_same_value(value, greatest);
    if (!is_greatest && !is_same_value(value, least)) {
      elsewhere.push_back(value);
      return;
    }
    ++(is_greatest ? at_greatest : at_least);
    found.runs.emplace_back(first, last);
    clipped += last - first + 1;
  });
  const auto holds = static_cast<double>(elsewhere.size() + found.runs.size());
  if (at_greatest >= kFewestHoldsAtEnd) found.greatest = greatest;
  if (at_least >= kFewestHoldsAtEnd) found.least = least;
  if (!found.greatest && !found.least) return std::nullopt;
  if (elsewhere.size() < kFewestHolds / 2 || holds < static_cast<double>(kFewestHolds) ||
      (static_cast<double>(at_greatest + at_least) < kLeastAtEnd * holds &&
       static_cast<double>(clipped) < kLeastAtEnd * static_cast<double>(rows))) {
    return std::nullopt;
  }
  std::sort(elsewhere.begin(), elsewhere.end());
  const auto distinct = std::unique(elsewhere.begin(), elsewhere.end(), is_same_value) - elsewhere.begin();
  if (static_cast<double>(distinct) < kLeastDistinct * static_cast<double>(elsewhere.size())) return std::nullopt;
  std::erase_if(found.runs, [&](const auto& run) {
    const double value = input[run.first];
    return !(found.greatest && is_same_value(value, greatest)) && !(found.least && is_same_value(value, least));
  });
  found.percent = 100.0 * static_cast<double>(clipped) / static_cast<double>(rows);
  return found;
}

std::optional<ClippedInput> clipped_input(const Eigen::VectorXd& input) {
  const std::optional<Ends> ends = ends_of(input);
  if (!ends) return std::nullopt;
  const auto [least, greatest] = *ends;
  const Index rows = input.size();
  ClippedInput found;
  Index clipped = 0;
  Index repeats = 0;
  double largest_move = 0.0;
  each_kept_value(input, [&](Index first, Index last) {
    const double value = input[first];
    const bool is_at_end = is_same_value(value, greatest) || is_same_value(value, least);
    if (is_at_end && last - first + 1 >= kShortestClip) {
      found.runs.emplace_back(first, last);
      clipped += last - first + 1;
      (is_same_value(value, greatest) ? found.greatest : found.least) = value;
    } else {
      repeats += last - first;
    }
    if (last + 1 < rows) largest_move = std::max(largest_move, std::abs(input[last + 1] - value));
  });
  for (const auto& [end, side] : {std::pair(&found.greatest, 1.0), std::pair(&found.least, -1.0)}) {
    if (*end && !stands_at_end(input, side)) return std::nullopt;
  }
  found.percent = 100.0 * static_cast<double>(clipped) / static_cast<double>(rows);
  const bool keeps_others = static_cast<double>(repeats) > kMostRepeatsBeside * static_cast<double>(rows - clipped);
  if (found.percent < 100.0 * kLeastClippedShare || keeps_others || largest_move > kGreatestMove * (greatest - least)) {
    return std::nullopt;
  }
  return found;
}

Eigen::VectorXd bridged(const Eigen::VectorXd& input, const ClippedInput& clipped, double scale) {
  Eigen::VectorXd found = input;
  const Index rows = input.size();
  for (const auto& [first, last] : clipped.runs) {
    const double end = input[first];
    const double side = clipped.greatest && is_same_value(end, *clipped.greatest) ? 1.0 : -1.0;
    // The slope to the first row of the run would be too small: it was cut off on the way.
    const auto slope = [&](Index from, Index to) {
      return to > from && from >= 0 && to < rows ? (input[to] - input[from]) / static_cast<double>(to - from) : 0.0;
    };
    const double into = std::max(0.0, side * slope(first - 1 - kSlopeRows, first - 1));
    const double out_of = std::max(0.0, -side * slope(last + 1, last + 1 + kSlopeRows));
    const auto length = static_cast<double>(last - first + 2);
    for (Index k = first; k <= last; ++k) {
      const double s = static_cast<double>(k - first + 1) / length;
      const double beyond = length * s * (1.0 - s) * ((1.0 - s) * into + s * out_of);
      found[k] = end + side * scale * beyond;
    }
  }
  return found;
}

}  // namespace eha::ident
