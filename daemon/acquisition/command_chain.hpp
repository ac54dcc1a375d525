// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

#include "config/rig_config.hpp"

namespace eha::acquisition {

/// Limits a requested voltage: clamps it to the rig's range, then moves the present command by at most the slew limit
/// of one tick towards it. The present command starts at the safe voltage. Real-time safe.
class CommandChain {
 public:
  struct Step {
    double command_V = 0.0;
    bool clamped = false;
    bool slew_limited = false;  ///< true: the slew limit binds; false: the (clamped) request is reached
  };

  CommandChain(const config::RigLimits& limits, double period_s) noexcept
      : minimum_V_(limits.command_min_V),
        maximum_V_(limits.command_max_V),
        largest_step_V_(limits.slew_V_per_s * period_s),
        present_V_(limits.safe_V) {}

  /// Returns the voltage to write for a finite request. Changes nothing, because the write may fail.
  [[nodiscard]] Step plan(double requested_V) const noexcept {
    Step step;
    const double target_V = std::clamp(requested_V, minimum_V_, maximum_V_);
    step.clamped = target_V < requested_V || target_V > requested_V;
    const double change_V = target_V - present_V_;
    step.slew_limited = std::abs(change_V) > largest_step_V_;
    step.command_V = step.slew_limited ? present_V_ + std::copysign(largest_step_V_, change_V) : target_V;
    return step;
  }

  /// Called after the voltage was written.
  void accept(double command_V) noexcept { present_V_ = command_V; }

 private:
  double minimum_V_;
  double maximum_V_;
  double largest_step_V_;
  double present_V_;
};

}  // namespace eha::acquisition
