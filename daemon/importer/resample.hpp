// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/importer/imported_table.hpp"

namespace eha::importer {

/// Columns on an even time grid.
struct Resampled {
  double start_s = 0.0;
  double step_s = 0.0;
  std::vector<std::vector<double>> columns;  ///< without the time
  std::vector<std::size_t> filled;           ///< rows (from 0) of which a value was not measured, ascending
  std::vector<std::size_t> held;             ///< of these, the rows whose held value was not measured
  std::vector<std::string> repairs;          ///< what was done, one sentence a gap or a stretch of jitter, in order
  std::size_t moved_rows = 0;                ///< to the grid
  double most_moved_s = 0.0;                 ///< by which one of them was moved
  bool is_averaged = false;                  ///< held values are means over their steps
};

/// Mean of the steps that are no gap: within three quarters of the median. To both sides alike, so that the scatter of
/// a clock leaves the mean where it is. @param steps  at least one
[[nodiscard]] double typical_step_s(std::vector<double> steps);

/// Puts rows on an even grid t_0 + k step. A grid point with a measured input within half a step, or between measured
/// rows at most 1.5 steps apart, takes the nearest (an input is held, so a late time stamp does not change it), and the
/// output interpolated linearly at the grid point. Where one of the two was not measured that near, the point is
/// `filled`: a missing output is interpolated, a missing input too, or held in a gap of ident::kRowsOfGap rows or more,
/// and the other one stays as measured. If more than three tenths of the rows are off the grid, a held value is the
/// mean over its step of what was held from row to row. Of rows of one time the later ones give what the first one
/// lacks, and are left out. The grid lies within the measured times of every column.
/// @param rows       columns: time [s], then held values (the input), then interpolated ones; NaN where missing
/// @param held       how many columns after the time are held
/// @param period_s   the step; none: the roundest number that the typical step allows
/// @throws DataError  time goes back, fewer than two values of a column, a gap longer than all that was measured, or a
/// period that is
///                    not about the typical step
/// Cost O(N).
[[nodiscard]] Resampled resample(const Rows& rows, std::size_t held, std::optional<double> period_s,
                                 const std::filesystem::path& path);

}  // namespace eha::importer
