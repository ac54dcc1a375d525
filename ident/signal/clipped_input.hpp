// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

namespace eha::ident {

/// Where an input stands exactly at its greatest or least value, as at the end of a logger's range or at the
/// limit of a command.
struct ClippedInput {
  std::vector<std::pair<Eigen::Index, Eigen::Index>> runs;  ///< first and last row of each, ascending
  std::optional<double> greatest = {};                      ///< where rows stand at it [input unit]
  std::optional<double> least = {};
  double percent = 0.0;  ///< of the rows
};

/// @returns none where fewer than 2 % of the rows stand so in runs of three or more, and for an input that keeps other
/// values too, or jumps, as steps, a square wave or a PRBS do, or is read in steps so coarse that its crests stand so.
/// Cost O(N).
[[nodiscard]] std::optional<ClippedInput> clipped_input(const Eigen::VectorXd& input);

/// The same of a staircase whose levels differ but for those at an end, or of an input that jumps from row to row: each
/// hold there is a run, and neighbours are one. @returns none of fewer than 20 holds, where fewer than a tenth of them
/// and of the rows stand at an end, and for levels that come again elsewhere, too, as those of a PRBS or of a sequence
/// of few do. Cost O(N log N).
[[nodiscard]] std::optional<ClippedInput> clipped_levels(const Eigen::VectorXd& input);

/// The input as it may have gone on beyond its ends: each run becomes a cubic that goes on with the slopes beside it,
/// whose way beyond the end is multiplied by `scale`, 1 for the cubic itself. [input unit]
/// @param clipped  of this input, as clipped_input() returns it. Cost O(N)
[[nodiscard]] Eigen::VectorXd bridged(const Eigen::VectorXd& input, const ClippedInput& clipped, double scale);

}  // namespace eha::ident
