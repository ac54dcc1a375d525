// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string_view>
#include <vector>

#include "core/keys.hpp"
#include "ident/excitation/level_timing.hpp"

namespace eha::ident {

/// 0 before hold_s, amplitude_V from the nearest tick on.
struct Step {
  static constexpr std::string_view kName = "step";

  double amplitude_V = 0.0;  ///< [V]
  double hold_s = 0.0;       ///< time before the step [s]

  static void visit_keys(auto& self, auto& keys) {
    keys.number("amplitude_V", self.amplitude_V, Range::above(0.0));
    keys.number("hold_s", self.hold_s, Range::above(0.0));
  }

  [[nodiscard]] Eigen::VectorXd volts(double step_s, std::size_t samples) const;
  [[nodiscard]] std::vector<OptionIssue> check_timing(double step_s, double duration_s) const {
    return check_hold(hold_s, step_s, duration_s);
  }
  [[nodiscard]] double shortest_level_s(double duration_s) const { return duration_s - hold_s; }
};

}  // namespace eha::ident
