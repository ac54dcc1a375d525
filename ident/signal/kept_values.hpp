// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

namespace eha::ident {

/// Whether two values are the same to the last digit. A NaN, a value that is missing, counts as the same as any.
[[nodiscard]] inline bool is_same_value(double a, double b) noexcept { return !(a < b) && !(a > b); }

/// Calls `take` with the first and the last row of each run of one value, in their order; a value that no neighbour
/// has is a run of one row. @param values  finite, in any unit. Cost O(N)
void each_kept_value(const Eigen::Ref<const Eigen::VectorXd>& values,
                     const std::function<void(Eigen::Index first, Eigen::Index last)>& take);

/// Whether the rows at the greatest value (side 1) or the least one (-1) are more than the crests of a motion that is
/// read in coarse steps: three times those at the next value inside, where a sine has 1.4 times. Cost O(N)
[[nodiscard]] bool stands_at_end(const Eigen::Ref<const Eigen::VectorXd>& values, double side);

}  // namespace eha::ident
