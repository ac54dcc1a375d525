// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/importer/table.hpp"

namespace eha::importer {

/// Columns on an even time grid.
struct Resampled {
  double start_s = 0.0;
  double step_s = 0.0;
  std::vector<std::vector<double>> columns;  ///< without the time
  std::vector<std::size_t> filled;           ///< rows (from 0) near which nothing was measured, ascending
  std::vector<std::string> repairs;          ///< what was done, one sentence a gap or a stretch of jitter, in order
};

/// Puts rows on an even grid t_0 + k step. A grid point with a measured row within half a step takes that row's input
/// (it is held, so a late time stamp does not change it) and the output interpolated linearly at the grid point. At
/// other points, `filled`, the input holds and the output is interpolated. Rows in which a value is missing count as
/// not measured; one at the time of the row before is left out.
/// @param rows       columns: time [s], then held values (the input), then interpolated ones; NaN where missing
/// @param held       how many columns after the time are held
/// @param period_s   the step; none: the roundest number that the typical step allows
/// @throws DataError  time goes back, fewer than two rows, a gap longer than all that was measured, or a period that is
///                    not about the typical step
/// Cost O(N).
[[nodiscard]] Resampled resample(const Rows& rows, std::size_t held, std::optional<double> period_s,
                                 const std::filesystem::path& path);

}  // namespace eha::importer
