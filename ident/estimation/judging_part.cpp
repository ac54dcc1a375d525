// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/judging_part.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/error.hpp"
#include "ident/estimation/fit_rows.hpp"

namespace eha::ident {
namespace {

// Standard deviation in the judging part over the range in the estimating one. An input is computed or measured with
// little noise; an output still settles, and has noise.
constexpr double kInputRests = 0.01;
constexpr double kOutputRests = 0.05;

bool rests(const Eigen::VectorXd& values, const FitRows& rows, const std::optional<double>& before, double share) {
  const auto first = static_cast<Eigen::Index>(rows.discarded);
  const auto judging = static_cast<Eigen::Index>(rows.last) + 1;
  const auto estimating = values.segment(first, judging - first);
  const auto judged = values.tail(values.size() - judging);
  const double least = std::min(estimating.minCoeff(), before.value_or(estimating[0]));
  const double greatest = std::max(estimating.maxCoeff(), before.value_or(estimating[0]));
  const double deviation = std::sqrt((judged.array() - judged.mean()).square().mean());
  return deviation <= share * (greatest - least) && greatest > least;
}

constexpr double kReach = 0.5;           // of the whole record's, on one side of the median
constexpr int kBins = 50;                // of the input's range
constexpr double kLevelShare = 0.01;     // of the rows, at a level
constexpr double kStaircaseShare = 0.9;  // of the rows, at the levels together
constexpr int kMostLevels = 20;

/// What an input does on either side of its median.
struct Sides {
  double above = 0.0;
  double below = 0.0;
  int levels_above = 0;
  int levels_below = 0;
  bool is_staircase = false;
};

Sides sides_of(const Eigen::Ref<const Eigen::VectorXd>& input, double least, double greatest, double median) {
  Sides sides{.above = input.maxCoeff() - median, .below = median - input.minCoeff()};
  std::array<double, kBins> bins{};
  const auto rows = static_cast<double>(input.size());
  const auto bin_of = [&](double u) {
    return std::clamp(static_cast<int>((u - least) / (greatest - least) * kBins), 0, kBins - 1);
  };
  for (const double u : input) bins[static_cast<std::size_t>(bin_of(u))] += 1.0 / rows;
  double share = 0.0;
  for (int i = 0; i < kBins; ++i) {
    const double at = bins[static_cast<std::size_t>(i)];
    if (at < kLevelShare) continue;
    share += at;
    if (i > bin_of(median)) ++sides.levels_above;
    if (i < bin_of(median)) ++sides.levels_below;
  }
  sides.is_staircase = share >= kStaircaseShare && sides.levels_above + sides.levels_below < kMostLevels;
  return sides;
}

bool covers(const Sides& part, const Sides& whole) {
  const auto has_two = [](int levels, int all) { return levels >= std::min(all, 2); };
  const bool has_levels =
      has_two(part.levels_above, whole.levels_above) && has_two(part.levels_below, whole.levels_below);
  return part.above >= kReach * whole.above && part.below >= kReach * whole.below &&
         (!whole.is_staircase || has_levels);
}

}  // namespace

std::optional<CoveringSplit> covering_split(const Record& record, const FitOptions& options) {
  if (!(options.split < 1.0)) return std::nullopt;
  try {
    check_record(record, options);
    FitOptions tried = options;
    const FitRows given = fit_rows(record, options);
    const auto first = static_cast<Eigen::Index>(given.discarded);
    const Eigen::VectorXd input = record.input.tail(record.input.size() - first);
    const double least = input.minCoeff();
    const double greatest = input.maxCoeff();
    if (!(greatest > least)) return std::nullopt;
    std::vector<double> sorted(input.begin(), input.end());
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const Sides whole = sides_of(input, least, greatest, *middle);
    const auto part_of = [&](const FitRows& rows) { return static_cast<Eigen::Index>(rows.last) + 1 - first; };
    const Eigen::Index estimating = part_of(given);
    if (estimating >= input.size() || covers(sides_of(input.head(estimating), least, greatest, *middle), whole)) {
      return std::nullopt;
    }
    const auto judging = input.tail(input.size() - estimating);
    for (const double share : {0.6, 0.7, 0.8, 0.9}) {
      tried.split = share;
      if (!(share > options.split)) continue;
      if (!covers(sides_of(input.head(part_of(fit_rows(record, tried))), least, greatest, *middle), whole)) continue;
      // Of the last step what is left would be noise alone.
      if (judging_part_rests(record, tried)) continue;
      return CoveringSplit{share, input.head(estimating).minCoeff(), input.head(estimating).maxCoeff(),
                           judging.minCoeff(), judging.maxCoeff()};
    }
  } catch (const DataError&) {
  }
  return std::nullopt;
}

bool judging_part_rests(const Record& record, const FitOptions& options) {
  if (!(options.split < 1.0)) return false;
  try {
    check_record(record, options);
    const FitRows rows = fit_rows(record, options);
    if (static_cast<Eigen::Index>(rows.last) + 1 >= record.input.size()) return false;
    return rests(record.input, rows, options.input_before, kInputRests) &&
           rests(record.output, rows, std::nullopt, kOutputRests);
  } catch (const DataError&) {
    return false;
  }
}

}  // namespace eha::ident
