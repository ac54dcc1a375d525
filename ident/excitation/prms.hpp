// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/keys.hpp"
#include "ident/excitation/level_timing.hpp"
#include "ident/excitation/seed.hpp"

namespace eha::ident {

/// Pseudo-random multilevel signal: every hold_s one of `levels` equidistant voltages in -amplitude_V..amplitude_V.
struct Prms {
  static constexpr std::string_view kName = "prms";

  double amplitude_V = 0.0;  ///< peak [V]
  int levels = 0;            ///< at least 3
  double hold_s = 0.0;       ///< shortest time on one level [s]
  std::uint64_t seed = kDefaultSeed;

  static void visit_keys(auto& self, auto& keys) {
    keys.number("amplitude_V", self.amplitude_V, Range::above(0.0));
    keys.integer("levels", self.levels, 3, 1000);
    keys.number("hold_s", self.hold_s, Range::above(0.0));
    keys.integer("seed", self.seed, 0, kGreatestSeed, Need::optional);
  }

  [[nodiscard]] Eigen::VectorXd volts(double step_s, std::size_t samples) const;
  [[nodiscard]] std::vector<OptionIssue> check_timing(double step_s, double duration_s) const {
    return check_hold(hold_s, step_s, duration_s);
  }
  [[nodiscard]] double shortest_level_s(double) const { return hold_s; }
};

}  // namespace eha::ident
