// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/valve_map.hpp"

#include <algorithm>

namespace eha::ident {
namespace {

double half_width(const ValveMap& map) { return std::max(0.0, map.dead_band); }

}  // namespace

double upper_edge(const ValveMap& map) { return map.null + half_width(map); }
double lower_edge(const ValveMap& map) { return map.null - half_width(map); }

Eigen::VectorXd is_above(const ValveMap& map, const Eigen::Ref<const Eigen::VectorXd>& input) {
  return (input.array() > upper_edge(map)).cast<double>();
}

Eigen::VectorXd is_below(const ValveMap& map, const Eigen::Ref<const Eigen::VectorXd>& input) {
  return (input.array() < lower_edge(map)).cast<double>();
}

Eigen::VectorXd mapped(const ValveMap& map, const Eigen::Ref<const Eigen::VectorXd>& input) {
  return (input.array() - upper_edge(map)).cwiseMax(0.0) +
         map.negative_gain_ratio * (input.array() - lower_edge(map)).cwiseMin(0.0);
}

}  // namespace eha::ident
