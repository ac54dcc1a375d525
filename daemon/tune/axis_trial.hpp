// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "hal/sim/sim_options.hpp"
#include "ident/control/axis_controller.hpp"

namespace eha::tune {

/// What is played in a trial.
struct TrialPlan {
  double step_in = 0.5;  ///< of the set point
  double sine_in = 0.2;  ///< amplitude
  double sine_Hz = 0.2;
  int trapezoids = 2;  ///< forth and back, as fast as the reference may
  double hold_s = 60.0;
  double lowest_in = 0.0;  ///< travel
  double highest_in = 0.0;
};

/// Step and sine that suit travel and limits of a controller.
[[nodiscard]] TrialPlan trial_plan(const ident::AxisSettings& settings);

/// What the true rod did. Errors are of the generated reference less the rod.
struct TrialFigures {
  double following_rms_in = 0.0;  ///< over the trapezoids, rests included
  double following_worst_in = 0.0;
  double sine_rms_in = 0.0;
  double overshoot_in = 0.0;     ///< beyond the step's end
  double settling_s = 0.0;       ///< after the reference has ended, until the error stays within 2 % of the step
  double rest_error_in = 0.0;    ///< greatest size, in the hold after its first 2 s
  double standing_in = 0.0;      ///< peak to peak of the rod, the same time
  double limited_percent = 0.0;  ///< ticks in which range or slew changed the command
  double swings_per_s = 0.0;     ///< most in any second of the command across its null, see SwingCounter
  double travelled_in = 0.0;     ///< way of the rod in the hold: grows with each oscillation
  bool has_left = false;         ///< the rod left its travel
};

/// Counts how often the command goes from beyond null + width to beyond null - width or back, over the last second.
/// Real-time safe. Not thread-safe.
class SwingCounter {
 public:
  SwingCounter(double null_V, double width_V, double tick_s) noexcept
      : null_V_(null_V), width_V_(width_V), tick_s_(tick_s) {}
  /// @returns swings in the last second
  int step(double command_V) noexcept;
  /// Swings that are remembered; more in a second count as so many.
  static constexpr int kMost = 256;

 private:
  double null_V_;
  double width_V_;
  double tick_s_;
  int side_ = 0;
  double now_s_ = 0.0;
  double at_s_[kMost] = {};
  int first_ = 0;
  int count_ = 0;
};

/// Width of a swing: half the dead band and what noise and speed need at rest.
[[nodiscard]] double swing_width_V(const ident::AxisSettings& settings);

/// Rows of a trial for figures: reference, rod and command, a row a tick from the start.
struct TrialTrace {
  std::vector<double> time_s;
  std::vector<double> reference_in;
  std::vector<double> rod_in;
  std::vector<double> command_V;
};

/// Plays the plan on one simulated rig, converters and noise included, at its seed.
/// @param trace  receives the rows up to the hold's tenth second, if not null
/// Precondition: hal::check(options) is empty. Cost: about 1 us a tick; 0.08 s for 80 s.
[[nodiscard]] TrialFigures axis_trial(const hal::SimOptions& options, const ident::AxisCoefficients& controller,
                                      const TrialPlan& plan, TrialTrace* trace = nullptr);

}  // namespace eha::tune
