// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/plot/envelope.hpp"

#include <algorithm>
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
    std::size_t least = begin;
    std::size_t greatest = begin;
    for (std::size_t i = begin; i < end; ++i) {
      if (!std::isfinite(y[i])) least = greatest = i;
      if (!std::isfinite(y[least])) break;
      if (y[i] < y[least]) least = i;
      if (y[i] > y[greatest]) greatest = i;
    }
    add(std::min(least, greatest));
    if (least != greatest) add(std::max(least, greatest));
  }
  return points;
}

}  // namespace eha::plot
