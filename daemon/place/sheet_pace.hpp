// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "ident/valve/sheet_plan.hpp"

namespace eha::place {

/// How far the volts of a valve sheet may be from the valve's null, by the valve as exploring has shown it.
struct PaceBounds {
  double edge_V = 0.0;   ///< the valve is open beyond
  double reach_V = 0.0;  ///< what gives the wanted speed
};

/// Scales the volts of a valve sheet, so that the rod is no faster than wanted whatever its gain is: the triangles as a
/// whole, the sines of each amplitude beyond the edge, which they stay outside of. Volts within reach stay as planned.
/// Real-time safe; cost: some ten operations a tick. Not thread-safe.
class SheetPace {
 public:
  /// @param null_V  that the plan was made about
  SheetPace(const ident::SheetPlan& plan, double null_V) noexcept;

  /// Call before the first row.
  void bound_by(const PaceBounds& bounds) noexcept;

  /// @param row  never decreasing   @param from_null_V  as planned   @returns volts from the null
  [[nodiscard]] double paced_V(std::uint32_t row, double from_null_V) noexcept;

 private:
  /// Rows up to `end` with volts to either side of the null: slope below `bend`, another one beyond.
  struct Part {
    std::uint32_t end = 0;
    double bend_V = 0.0;  ///< the least of the sines; the peak of triangles
    double peak_V = 0.0;
    double slope = 1.0;
    double slope_beyond = 1.0;
  };

  std::array<Part, 2 + ident::kSheetAmplitudes.size()> parts_{};  ///< rest, triangles, sines of each amplitude
  std::size_t count_ = 0;
  std::size_t at_ = 0;
};

}  // namespace eha::place
