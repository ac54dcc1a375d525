// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace eha::plot {

/// Points of a curve.
struct Points {
  std::vector<double> x;
  std::vector<double> y;
};

/// Reduces a long signal to fewer points that draw the same picture: the least and the greatest value of each of
/// `buckets` equal parts, in their order. Returns a signal of at most two samples a bucket whole. A bucket with values
/// that are not finite keeps the first of them beside its least and greatest.
/// @param x, y  of one length; buckets > 0. Cost O(N).
[[nodiscard]] Points envelope(std::span<const double> x, std::span<const double> y, std::size_t buckets = 500);

}  // namespace eha::plot
