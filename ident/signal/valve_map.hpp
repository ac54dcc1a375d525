// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace eha::ident {

/// A valve as a static map from its input u to what passes:
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

/// One side of the map before its gain: v = above.excess + negative_gain_ratio below.excess.
struct ValveSide {
  Eigen::VectorXd excess;  ///< u less the edge of the dead band where u lies beyond it, else 0 [input unit]
  Eigen::VectorXd beyond;  ///< 1 where u lies beyond the edge, else 0: the slope of `excess` by u
};

/// Cost O(N).
[[nodiscard]] ValveSide above(const ValveMap& map, const Eigen::Ref<const Eigen::VectorXd>& input);
[[nodiscard]] ValveSide below(const ValveMap& map, const Eigen::Ref<const Eigen::VectorXd>& input);

}  // namespace eha::ident
