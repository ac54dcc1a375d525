// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

namespace eha::ident {

/// The value in the middle, of an even count the mean of the two. @param values  at least one. Cost O(N).
[[nodiscard]] double median_of(std::vector<double> values);

/// The standard deviation of values about 0, of which few are outliers: 1.4826 times the median of their sizes, as of a
/// normal distribution. @param values  at least one. Cost O(N). Hampel, JASA 69 (1974).
[[nodiscard]] double robust_std(std::vector<double> values);

/// Standard deviation of white noise in readings of something that moves smoothly from row to row, by their second
/// differences, robustly. @param readings  at least three, of one step. Cost O(N).
[[nodiscard]] double scatter_of_rows(const Eigen::VectorXd& readings);

}  // namespace eha::ident
