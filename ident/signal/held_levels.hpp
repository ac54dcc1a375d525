// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

namespace eha::ident {

/// The levels that an input was held at, from a record of them with noise: of rows that differ by no more than their
/// noise, and of holds at nearly the same level, the mean [input unit]. The noise is of the measuring channel; what
/// reached the plant were the levels. None of an input without noise, of one that moves in most rows and of one whose
/// rows between its jumps drift. Noise is measured by the median of the differences of neighbours, so most of those
/// must lie within a level.
/// @param input  N rows @returns N rows. Cost O(N).
[[nodiscard]] std::optional<Eigen::VectorXd> held_levels(const Eigen::Ref<const Eigen::VectorXd>& input);

/// The lower and the upper of the levels of an input that is nearly always at one of two, noise or not, equal for a
/// constant one; nothing of another. A record that begins at rest may have a third level for a while.
/// Cost O(N).
[[nodiscard]] std::optional<std::array<double, 2>> two_levels(const Eigen::Ref<const Eigen::VectorXd>& input);

}  // namespace eha::ident
