// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <vector>

#include "ident/statistics/robust.hpp"
#include "ident/validation/record_findings.hpp"

namespace eha::ident {
namespace {

using Eigen::Index;

constexpr Index kFewestRowsOfBurst = 60;
constexpr double kFarOverUsual = 6.0;    // standard deviations of most rows: beyond it a row belongs to a burst
constexpr double kPeakOverUsual = 20.0;  // the same: a burst reaches it
constexpr double kMostOfRows = 0.1;
constexpr double kLeastOfAll = 0.02;   // of the squares of all, of a burst that counts
constexpr double kLeastOfError = 0.8;  // of its squares
constexpr double kJoined = 0.01;       // of the rows, between two that belong to one burst
constexpr std::size_t kMostBursts = 3;

struct Burst {
  Index first = 0;
  Index last = 0;
  double squares = 0.0;
};

}  // namespace

std::optional<ErrorJump> error_burst(const ComparedRows& rows) {
  const Index count = rows.measured.size();
  if (count < kFewestRowsOfBurst || rows.simulated.size() != count || rows.time_s.size() != count) return std::nullopt;
  Eigen::VectorXd e = rows.measured - rows.simulated;
  if (!e.allFinite()) return std::nullopt;
  e.array() -= median_of({e.begin(), e.end()});
  const double usual = robust_std({e.begin(), e.end()});
  const double greatest = e.cwiseAbs().maxCoeff();
  if (!(usual > 0.0) || !(greatest > kPeakOverUsual * usual)) return std::nullopt;
  const auto joined = static_cast<Index>(std::ceil(kJoined * static_cast<double>(count)));
  std::vector<Burst> bursts;
  for (Index k = 0; k < count; ++k) {
    if (!(std::abs(e[k]) > kFarOverUsual * usual)) continue;
    if (bursts.empty() || k - bursts.back().last > joined) bursts.push_back({k, k});
    bursts.back().last = k;
  }
  double squares = 0.0;
  Index length = 0;
  for (Burst& burst : bursts) {
    length += burst.last - burst.first + 1;
    burst.squares = e.segment(burst.first, burst.last - burst.first + 1).squaredNorm();
    squares += burst.squares;
  }
  // Of single rows a few stand far out in any long record of a sensor.
  std::erase_if(bursts, [&](const Burst& burst) { return burst.squares < kLeastOfAll * squares; });
  if (bursts.size() > kMostBursts || static_cast<double>(length) > kMostOfRows * static_cast<double>(count) ||
      !(squares > kLeastOfError * e.squaredNorm())) {
    return std::nullopt;
  }
  const Burst& most = *std::max_element(bursts.begin(), bursts.end(),
                                        [](const Burst& a, const Burst& b) { return a.squares < b.squares; });
  // At an end of the record it is a start that was not at rest, or an input that ended.
  if (most.first == 0 || most.last + 1 == count || most.last == most.first) return std::nullopt;
  const auto part = e.segment(most.first, most.last - most.first + 1);
  const double peak = std::abs(part.maxCoeff()) > std::abs(part.minCoeff()) ? part.maxCoeff() : part.minCoeff();
  return ErrorJump{.time_s = rows.time_s[most.first],
                   .change = peak,
                   .usual = kPeakOverUsual * usual,
                   .until_s = rows.time_s[most.last]};
}

}  // namespace eha::ident
