// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace eha::ident {

/// First and last row of each stretch over which an input that moves with every other row keeps one value to the bit,
/// while the output goes on to turn about as it does elsewhere: what the plant got was not recorded. Behind an input
/// that is held in truth a plant comes to rest or to an even speed. Of an input that keeps other values too, as steps
/// do, the longest stretch alone, of a tenth of the rows and five times the next one. Empty where noise hides how the
/// output turns.
/// @param input, output  of equal length, in any units. Cost O(N) for each stretch, of which there are at most 100
[[nodiscard]] std::vector<std::pair<Eigen::Index, Eigen::Index>> frozen_input(const Eigen::VectorXd& input,
                                                                              const Eigen::VectorXd& output);

}  // namespace eha::ident
