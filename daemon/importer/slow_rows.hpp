// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>

namespace eha::importer {

/// Says that the rows are too slow for a plant: the output answers within the row in which the input moves, so that
/// what precedes a row explains it far worse than the row's own input. Of a plant that comes to rest; a rod that
/// integrates does not show it. Empty where the rows show how the output answers. Cost O(N)
[[nodiscard]] std::string remark_on_slow_rows(const Eigen::VectorXd& input, const Eigen::VectorXd& output,
                                              double step_s);

/// The same of any plant, as a cause of a model's error: the input of the next row, which a plant does not know yet,
/// explains a good part of a motion that all before leaves open. Empty where it does not. Cost O(N)
[[nodiscard]] std::string motion_within_rows(const Eigen::VectorXd& input, const Eigen::VectorXd& output,
                                             double step_s);

}  // namespace eha::importer
