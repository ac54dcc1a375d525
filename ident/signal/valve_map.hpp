// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace eha::ident {

/// A valve as a static map from its input u to its effective input v:
///   v = 0                                            where |u - null| <= dead_band,
///   v = u - null - dead_band                         above,
///   v = negative_gain_ratio (u - null + dead_band)   below.
struct ValveMap {
  double null = 0.0;                 ///< middle of the dead band [input unit]
  double dead_band = 0.0;            ///< half width [input unit]; a negative one counts as 0
  double negative_gain_ratio = 1.0;  ///< gain below the dead band over the gain above it
};

/// v for N samples of u [input unit]. Cost O(N).
[[nodiscard]] Eigen::VectorXd mapped(const ValveMap& map, const Eigen::Ref<const Eigen::VectorXd>& input);

/// Edges of the dead band: v = max(u - upper_edge, 0) + negative_gain_ratio min(u - lower_edge, 0).
[[nodiscard]] double upper_edge(const ValveMap& map);
[[nodiscard]] double lower_edge(const ValveMap& map);

/// 1 where u lies beyond the edge, else 0: the slope of v by u, for a ratio of 1. Cost O(N).
[[nodiscard]] Eigen::VectorXd is_above(const ValveMap& map, const Eigen::Ref<const Eigen::VectorXd>& input);
[[nodiscard]] Eigen::VectorXd is_below(const ValveMap& map, const Eigen::Ref<const Eigen::VectorXd>& input);

}  // namespace eha::ident
