// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "ident/model/model.hpp"
#include "ident/record.hpp"
#include "ident/signal/clipped_input.hpp"

namespace eha::ident {

/// A staircase with the levels that its clipped holds may have had.
struct LevelsBeyond {
  Eigen::VectorXd input;      ///< N rows [input unit]
  double share_beyond = 0.0;  ///< of the holds whose level lies beyond the end where the record has it
};

/// By least squares of what the plant leaves over:
///   y - M(u) = sum_k c_k G(box_k) + c_bias G(1) + c_0,   box_k = 1 in the kth hold and 0 elsewhere,
/// of a model M and its transfer function G: beyond its dead band a map of the input has about the slope 1.
/// @param input    of the record, or as a round before returned it [input unit]
/// @param clipped  of the record's input, as clipped_levels() returns it
/// @param model    of that input; does not grow. Cost O(N holds^2)
[[nodiscard]] LevelsBeyond levels_beyond(const Record& record, const Eigen::VectorXd& input,
                                         const ClippedInput& clipped, const Model& model);

}  // namespace eha::ident
