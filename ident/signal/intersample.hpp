// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/record.hpp"

namespace eha::ident {

/// What the input does between two rows. The field's names for both are zero-order and first-order hold.
enum class Intersample {
  held,      ///< row k's value until row k+1, as a controller's output
  straight,  ///< a straight line from row to row, as a signal that was sampled
  smooth,    ///< cubics through four rows, as a signal without motion between the rows; tells the other two apart
};

/// Rows that with_straight_input() makes of one.
inline constexpr int kPartsOfARow = 8;

/// The record as one of kPartsOfARow rows for each, whose input is held: where it moves between the rows, at the
/// curve's value at the middle of each part. The output is interpolated by cubics through four rows; every
/// kPartsOfARow-th row is a measured one, at which models are to be compared.
/// @param record  at least four rows
/// Cost O(N), kPartsOfARow times the memory.
[[nodiscard]] Record in_parts(const Record& record, Intersample intersample);

/// The input at the rows that were recorded, also of a record that in_parts() has made with straight lines. Cost O(N).
[[nodiscard]] Eigen::VectorXd recorded_input(const Record& record);

/// How far the input moves within half a row [share of its standard deviation], root mean square, where it moves in
/// most rows and goes on as it moved in the row before, as a sampled signal does; 0 where it jumps from level to level.
/// Half a row of delay is what a model gets that takes such an input as held.
[[nodiscard]] double movement_within_half_a_row(const Eigen::Ref<const Eigen::VectorXd>& input);

}  // namespace eha::ident
