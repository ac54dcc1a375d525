// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/plot/envelope.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace eha::plot {

Points envelope(std::span<const double> x, std::span<const double> y, std::size_t buckets) {
  if (y.size() <= 2 * buckets) return {{x.begin(), x.end()}, {y.begin(), y.end()}};
  Points points;
  const auto add = [&](std::size_t i) {
    points.x.push_back(x[i]);
    points.y.push_back(y[i]);
  };
  for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
    const std::size_t begin = bucket * y.size() / buckets;
    const std::size_t end = (bucket + 1) * y.size() / buckets;
    // Places of the least, the greatest and the first value that is not finite; `end` without one.
    std::size_t least = end;
    std::size_t greatest = end;
    std::size_t gap = end;
    for (std::size_t i = begin; i < end; ++i) {
      if (!std::isfinite(y[i])) {
        gap = std::min(gap, i);
        continue;
      }
      if (least == end || y[i] < y[least]) least = i;
      if (greatest == end || y[i] > y[greatest]) greatest = i;
    }
    std::array<std::size_t, 3> kept{least, greatest, gap};
    std::sort(kept.begin(), kept.end());
    for (std::size_t i = 0; i < kept.size(); ++i) {
      if (kept[i] != end && (i == 0 || kept[i] != kept[i - 1])) add(kept[i]);
    }
  }
  return points;
}

}  // namespace eha::plot
