// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/valve_map.hpp"

#include <algorithm>

namespace eha::ident {
namespace {

double half_width(const ValveMap& map) { return std::max(0.0, map.dead_band); }

}  // namespace

ValveSide above(const ValveMap& map, const Eigen::Ref<const Eigen::VectorXd>& input) {
  const Eigen::ArrayXd distance = input.array() - (map.null + half_width(map));
  return {distance.cwiseMax(0.0), (distance > 0.0).cast<double>()};
}

ValveSide below(const ValveMap& map, const Eigen::Ref<const Eigen::VectorXd>& input) {
  const Eigen::ArrayXd distance = input.array() - (map.null - half_width(map));
  return {distance.cwiseMin(0.0), (distance < 0.0).cast<double>()};
}

Eigen::VectorXd mapped(const ValveMap& map, const Eigen::Ref<const Eigen::VectorXd>& input) {
  return above(map, input).excess + map.negative_gain_ratio * below(map, input).excess;
}

}  // namespace eha::ident
