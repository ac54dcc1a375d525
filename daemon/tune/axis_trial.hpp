// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "hal/sim/sim_options.hpp"
#include "ident/control/trial.hpp"

namespace eha::tune {

/// Rows of a trial for figures: reference, rod and command, a row a tick from the start.
struct TrialTrace {
  std::vector<double> time_s;
  std::vector<double> reference_in;
  std::vector<double> rod_in;
  std::vector<double> command_V;
  /// Begin and end of the sweep that measures the margins, in which the rod follows no reference; none without one.
  std::optional<std::pair<double, double>> sweep_s = {};
  std::optional<double> mean_s = {};  ///< rod and reference are means over this; none: single rows
};

/// Plays the plan on one simulated rig with its seed, converters and noise included. The figures use the rod's true
/// position.
/// @param trace  receives the rows up to the hold's tenth second, if not null
/// Precondition: hal::check(options) is empty. Cost: about 0.6 us a tick; 0.05 s for 80 s.
[[nodiscard]] ident::TrialFigures axis_trial(const hal::SimOptions& options, const ident::AxisCoefficients& controller,
                                             const ident::TrialPlan& plan, TrialTrace* trace = nullptr);

}  // namespace eha::tune
