// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ident/validation/record_findings.hpp"

namespace eha::ident {

/// Rows first .. last, of an output that stands.
struct StandingRows {
  Eigen::Index first = 0;
  Eigen::Index last = 0;
};

/// Finds where a plant does not answer: the output stands within `width` for six windows or more, while the input
/// goes on by half its standard deviation, the model moves, and elsewhere the output moves with the same input and with
/// the model. At the output's greatest or least value the input must also ask the output back, which a rod on its end
/// stop would follow.
/// @param width   from least to greatest sample of an output that stands [output unit]
/// @param window  rows over which a motion is counted
/// Cost O(N + W^2) for W windows.
[[nodiscard]] std::vector<StandingRows> unanswered(const ComparedRows& rows, double width, Eigen::Index window);

}  // namespace eha::ident
