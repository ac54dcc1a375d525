// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>

#include "config/rig_config.hpp"
#include "daemon/acquisition/limit_monitor.hpp"
#include "daemon/place/slow_motion.hpp"

namespace eha::place {

/// The following check of a rig without [following], learnt while it moves. In slow motion it measures the speed at
/// each voltage, in steps of 1/64 of the command range. From then on the rod must move at least at half of the speed
/// v(u) that it had at a voltage not beyond the present one:
///   S_d = max(0, S_d + d v(u) / 2 dt - d dy) where d v(u) > 0;   not_following at S_d > 0.1 in
/// u and y pass the same low-pass filter twice (0.05 s). Finds a sensor that fails and a rod that meets an end stop
/// under volts that moved it before; does not find a wrong scale by itself. Real-time safe; cost: one pass over the
/// steps. Not thread-safe.
class LearnedMonitor {
 public:
  LearnedMonitor(const config::RigLimits& limits, double period_s) noexcept;

  /// Once a tick. @param command_V  held since the reading before   @param displacement_in  finite
  void note(double command_V, double displacement_in) noexcept;

  [[nodiscard]] const acquisition::Breach& breach() const noexcept { return breach_; }

 private:
  struct Step {
    double speed_in_per_s = 0.0;  ///< mean
    double time_s = 0.0;
  };
  static constexpr std::size_t kSteps = 64;

  [[nodiscard]] std::size_t step_of(double command_V) const noexcept;
  void learn(double speed_in_per_s) noexcept;
  void check(double speed_in_per_s) noexcept;

  double lowest_V_;
  double step_V_;
  double period_s_;
  SlowMotion motion_;
  std::array<Step, kSteps> steps_{};
  std::array<double, 2> missing_in_{};
  acquisition::Breach breach_;
};

}  // namespace eha::place
