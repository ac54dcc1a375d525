// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/plot/axis_range.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace eha::plot {
namespace {

constexpr double kXIntervals = 8.0;
constexpr double kYIntervals = 4.0;

void extend(Range& range, double value) {
  if (!std::isfinite(value)) return;
  if (!range) range = std::pair(value, value);
  range = std::pair(std::min(range->first, value), std::max(range->second, value));
}

/// Range of the values that a panel shows on its y axis; none without a value.
Range y_extent(const Panel& panel) {
  if (panel.y_range) return panel.y_range;
  Range extent;
  for (const Series& series : panel.series) {
    for (const std::vector<double>* values : {&series.y, &series.lower, &series.upper}) {
      for (const double value : *values) extend(extent, value);
    }
  }
  return extent;
}

/// Returns a distance of tick marks: 1, 2 or 5 times a power of ten, or a usual part of a turn; about `intervals` of
/// them cover the range. 0 for a range without a length.
double tick_step(const Range& range, double intervals, bool is_angle = false) {
  const double wanted = range ? (range->second - range->first) / intervals : 0.0;
  if (!(wanted > 0.0) || !std::isfinite(wanted)) return 0.0;
  if (is_angle && wanted > 7.0) return wanted < 18.0 ? 15.0 : wanted < 35.0 ? 30.0 : 45.0 * std::ceil(wanted / 60.0);
  const double power = std::pow(10.0, std::floor(std::log10(wanted)));
  const double digit = wanted / power;
  return power * (digit < 1.2 ? 1.0 : digit < 2.5 ? 2.0 : digit < 6.0 ? 5.0 : 10.0);
}

}  // namespace

double y_step(const Panel& panel) {
  constexpr double kFewest = 3.0;  // marks
  const Range extent = y_extent(panel);
  const bool is_angle = panel.y_label.ends_with("[deg]");
  const double step = tick_step(extent, kYIntervals, is_angle);
  if (!(step > 0.0) || !panel.y_range) return step;
  const double marks = std::floor(extent->second / step) - std::ceil(extent->first / step) + 1.0;
  return marks < kFewest ? tick_step(extent, 2.0 * kYIntervals, is_angle) : step;
}

Range y_ends(const Panel& panel) {
  const Range extent = y_extent(panel);
  const double step = y_step(panel);
  if (panel.y_range || !extent || !(step > 0.0)) return extent;
  return std::pair(step * std::floor(extent->first / step), step * std::ceil(extent->second / step));
}

Range x_range_of(const Figure& figure) {
  constexpr double kNear = 0.03;  // of the length
  Range extent;
  for (const Panel& panel : figure.panels) {
    if (panel.x_range || panel.log_x || !panel.x_ticks.empty()) continue;
    for (const Series& series : panel.series) {
      for (const double value : series.x) extend(extent, value);
    }
  }
  const double step = tick_step(extent, kXIntervals);
  if (!(step > 0.0)) return std::nullopt;
  const double near = kNear * (extent->second - extent->first);
  const double before = step * std::floor(extent->first / step);
  const double after = step * std::ceil(extent->second / step);
  if (extent->first - before < near) extent->first = before;
  if (after - extent->second < near) extent->second = after;
  return extent;
}

double x_step(const Range& range) { return tick_step(range, kXIntervals); }

}  // namespace eha::plot
