// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

namespace eha::ident {

/// Returns the levels that an input was held at, from a record of them with noise: of rows that differ by no more than
/// their noise the mean. The noise is of the measuring channel; what reached the plant were the levels. An input
/// without noise, one that moves in most rows and one whose rows between its jumps drift are returned as they are.
/// Noise is measured by the median of the differences of neighbours, so most of those must lie within a level.
/// Cost O(N).
[[nodiscard]] Eigen::VectorXd held_levels(const Eigen::Ref<const Eigen::VectorXd>& input);

/// The lower and the upper of the levels of an input that is nearly always at one of two, noise or not, equal for a
/// constant one; nothing of another. A record that begins at rest may have a third level for a while.
/// Cost O(N).
[[nodiscard]] std::optional<std::array<double, 2>> two_levels(const Eigen::Ref<const Eigen::VectorXd>& input);

}  // namespace eha::ident
