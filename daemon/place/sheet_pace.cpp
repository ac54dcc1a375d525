// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/place/sheet_pace.hpp"

#include <algorithm>
#include <cmath>

namespace eha::place {

SheetPace::SheetPace(const ident::SheetPlan& plan, double null_V) noexcept {
  const Eigen::ArrayXd sizes_V = (plan.table_V.array() - null_V).abs();
  const auto peak_V_of = [&](Eigen::Index first, Eigen::Index end) {
    return sizes_V.segment(first, end - first).maxCoeff();
  };
  parts_[count_++] = {.end = static_cast<std::uint32_t>(plan.sweep_first)};
  const Eigen::Index sweep_end = plan.sweep_first + plan.sweep_rows;
  const double sweep_V = peak_V_of(plan.sweep_first, sweep_end);
  parts_[count_++] = {.end = static_cast<std::uint32_t>(sweep_end), .bend_V = sweep_V, .peak_V = sweep_V};
  Eigen::Index from = sweep_end;
  for (std::size_t level = 0; level < ident::kSheetAmplitudes.size(); ++level) {
    Eigen::Index end = from;
    double least_V = 0.0;
    for (const ident::SineSegment& sine : plan.sines) {
      if (sine.level != level) continue;
      end = sine.first + sine.rows;
      least_V = std::abs(sine.bias_V) - sine.amplitude_V;
    }
    if (end == from) continue;
    parts_[count_++] = {.end = static_cast<std::uint32_t>(end), .bend_V = least_V, .peak_V = peak_V_of(from, end)};
    from = end;
  }
}

void SheetPace::bound_by(const PaceBounds& bounds) noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    Part& part = parts_[i];
    if (part.peak_V <= bounds.reach_V) continue;
    if (part.bend_V >= part.peak_V) {
      part.slope = bounds.reach_V / part.peak_V;
      continue;
    }
    const double bend_V = std::min({part.bend_V, bounds.edge_V, bounds.reach_V});
    part.slope = bend_V / part.bend_V;
    part.slope_beyond = (bounds.reach_V - bend_V) / (part.peak_V - part.bend_V);
  }
}

double SheetPace::paced_V(std::uint32_t row, double from_null_V) noexcept {
  while (at_ < count_ && row >= parts_[at_].end) ++at_;
  if (at_ == count_) return from_null_V;
  const Part& part = parts_[at_];
  const double size_V = std::abs(from_null_V);
  const double paced_V =
      part.slope * std::min(size_V, part.bend_V) + part.slope_beyond * std::max(0.0, size_V - part.bend_V);
  return std::copysign(paced_V, from_null_V);
}

}  // namespace eha::place
