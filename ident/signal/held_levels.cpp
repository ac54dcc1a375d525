// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/held_levels.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "ident/statistics/robust.hpp"

namespace eha::ident {
namespace {

constexpr double kWithinNoise = 6.0;                // standard deviations; a level of 10^5 rows exceeds 4.4
constexpr double kSpanOverNoise = 25.0;             // of the input; below it levels and noise are not told apart
constexpr Eigen::Index kMostDifferences = 100'000;  // more do not sharpen the median
constexpr Eigen::Index kShortestMean = 6;           // rows of a level, in the mean
// Of the squared change from row to row, over the variance about the mean: 2 of white noise, below 0.3 of rows that
// drift.
constexpr double kLeastRoughness = 0.8;
constexpr double kWidestLevel = 3.0;  // standard deviations, between the means of its holds
constexpr double kSameLevel = 0.02;   // of the input's range
constexpr double kMostNoise = 0.2;    // of the range, at either level
constexpr double kElsewhere = 0.05;   // of the rows

/// The standard deviation of white noise on an input that is held in most rows; 0 where most rows repeat their value.
double noise_of(const Eigen::Ref<const Eigen::VectorXd>& input) {
  const Eigen::Index every = 1 + (input.size() - 2) / kMostDifferences;
  std::vector<double> differences;
  for (Eigen::Index k = 1; k < input.size(); k += every) differences.push_back(input[k] - input[k - 1]);
  return robust_std(std::move(differences)) / std::sqrt(2.0);
}

/// Rows that are held at one level.
struct Hold {
  Eigen::Index begin;
  Eigen::Index rows;
  double level;
};

/// Gives holds of nearly the same level, as a command returns to, the mean of their rows.
void join_levels(std::vector<Hold>& holds, double noise) {
  std::sort(holds.begin(), holds.end(), [](const Hold& a, const Hold& b) { return a.level < b.level; });
  for (auto from = holds.begin(); from != holds.end();) {
    auto to = from + 1;
    double sum = from->level * static_cast<double>(from->rows);
    auto rows = static_cast<double>(from->rows);
    for (; to != holds.end() && to->level - (to - 1)->level <= noise; ++to) {
      sum += to->level * static_cast<double>(to->rows);
      rows += static_cast<double>(to->rows);
    }
    // A chain of random levels is no level.
    if ((to - 1)->level - from->level <= kWidestLevel * noise) {
      for (auto hold = from; hold != to; ++hold) hold->level = sum / rows;
    }
    from = to;
  }
}

/// Whether nearly all rows lie at the least or the greatest value, within a share of the range.
bool is_at_two(const Eigen::Ref<const Eigen::VectorXd>& input, const std::array<double, 2>& levels, double share) {
  const double near = share * (levels[1] - levels[0]);
  const auto at = [&](double level) { return ((input.array() - level).abs() <= near).count(); };
  const Eigen::Index elsewhere = input.size() - at(levels[0]) - at(levels[1]);
  return static_cast<double>(elsewhere) <= kElsewhere * static_cast<double>(input.size());
}

std::array<double, 2> extremes(const Eigen::Ref<const Eigen::VectorXd>& input) {
  return {input.minCoeff(), input.maxCoeff()};
}

}  // namespace

std::optional<Eigen::VectorXd> held_levels(const Eigen::Ref<const Eigen::VectorXd>& input) {
  if (input.size() < 2 * kShortestMean) return std::nullopt;
  const double noise = noise_of(input);
  if (!(noise > 0.0) || input.maxCoeff() - input.minCoeff() < kSpanOverNoise * noise) return std::nullopt;
  const auto most_holds = static_cast<std::size_t>(input.size() / kShortestMean);
  std::vector<Hold> holds;
  double about_mean = 0.0;
  double rough = 0.0;
  for (Eigen::Index begin = 0; begin < input.size();) {
    double sum = input[begin];
    Eigen::Index end = begin + 1;
    for (; end < input.size() && std::abs(input[end] - sum / static_cast<double>(end - begin)) <= kWithinNoise * noise;
         ++end) {
      sum += input[end];
    }
    const Eigen::Index rows = end - begin;
    const double level = sum / static_cast<double>(rows);
    const auto held = input.segment(begin, rows);
    about_mean += (held.array() - level).square().sum();
    rough += (held.tail(rows - 1) - held.head(rows - 1)).squaredNorm();
    holds.push_back({begin, rows, level});
    if (holds.size() > most_holds) return std::nullopt;
    begin = end;
  }
  if (rough < kLeastRoughness * about_mean) return std::nullopt;
  join_levels(holds, noise);
  Eigen::VectorXd levels(input.size());
  for (const Hold& hold : holds) levels.segment(hold.begin, hold.rows).setConstant(hold.level);
  return levels;
}

std::optional<std::array<double, 2>> two_levels(const Eigen::Ref<const Eigen::VectorXd>& input) {
  const std::array<double, 2> range = extremes(input);
  if (!(range[1] > range[0])) return range;
  if (!is_at_two(input, range, kMostNoise)) return {};
  const std::optional<Eigen::VectorXd> held = held_levels(input);
  if (!held) return is_at_two(input, range, kSameLevel) ? std::optional(range) : std::nullopt;
  const std::array<double, 2> levels = extremes(*held);
  return is_at_two(*held, levels, kSameLevel) ? std::optional(levels) : std::nullopt;
}

}  // namespace eha::ident
