// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace eha::ident {

/// Whether an output that stays at its greatest and at its least value does so under one and the same input: a plant
/// that integrates and rests there, as nothing moves it. No input presses a rod on both of its ends.
/// @param input, output  of one length; values at an end are equal to the bit
/// @returns false where either end has fewer than 8 rows
/// Cost O(N).
[[nodiscard]] bool rests_at_both_ends(const Eigen::Ref<const Eigen::VectorXd>& input,
                                      const Eigen::Ref<const Eigen::VectorXd>& output);

}  // namespace eha::ident
