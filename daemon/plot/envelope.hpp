// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace eha::plot {

/// A curve's points.
struct Points {
  std::vector<double> x;
  std::vector<double> y;
};

/// Fewer points that draw the same picture: of each of `buckets` equal parts of a long signal the least and the
/// greatest value, in their order. A signal of at most two samples a bucket is returned whole. A bucket that holds a
/// value that is not finite keeps it. @param x, y  of one length; buckets > 0. Cost O(N).
[[nodiscard]] Points envelope(std::span<const double> x, std::span<const double> y, std::size_t buckets = 500);

}  // namespace eha::plot
