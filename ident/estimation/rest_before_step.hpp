// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>

namespace eha::ident {

/// The input level from which a step test starts at rest: its input moves once, from one level to another, and its
/// output is level until then; nothing for other records. Such a record cannot separate bias, offset, initial state and
/// gain, so the plant is assumed to be at rest at that level. Levels may vary by 1 % of the input's range, a level
/// output by 5 % of the output's range, noise included.
/// @param input, output  rows of one record [input unit, output unit], as many of each, at least one
/// @returns mean input before it moves [input unit]. Cost O(N).
[[nodiscard]] std::optional<double> rest_of_step_test(const Eigen::Ref<const Eigen::VectorXd>& input,
                                                      const Eigen::Ref<const Eigen::VectorXd>& output);

}  // namespace eha::ident
