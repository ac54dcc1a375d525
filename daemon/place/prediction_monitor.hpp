// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>

#include "daemon/acquisition/limit_monitor.hpp"
#include "daemon/place/forgetting_line.hpp"
#include "daemon/place/slow_motion.hpp"

namespace eha::place {

/// The straight flow curve of one direction, d = 1 or -1:  d v = gain (d u - edge)
struct FlowLine {
  double gain_in_per_V_s = 0.0;
  double edge_V = 0.0;  ///< of d u
};

/// Compares a rod with the valve that its own slow motion has shown. While it learns, it fits a line to volts and speed
/// of each direction (least squares with forgetting, 0.014 to 0.2 in/s, both through the same low-pass filter twice, of
/// 0.05 s). A line is known once its speeds spread by 0.01 in/s. With it
///   M_d = max(0, M_d + (0.4 gain (d u - edge - 0.02 V) - max(0, d v)) dt);            no_motion at 0.03 in
///   X_d = max(0, X_d + (d v - 2.5 gain max(0, d u - edge + 0.03 V) - 0.05 in/s) dt);  unexplained_motion at 0.05 in
/// the first while the volts ask for motion.
/// Finds a sensor that stops or jumps under volts that move the rod, without knowing the rig beforehand. Does not find
/// a wrong scale. Real-time safe; cost: some forty operations. Not thread-safe.
class PredictionMonitor {
 public:
  explicit PredictionMonitor(double period_s) noexcept;

  /// Once a tick. @param command_V  held since the reading before   @param displacement_in  finite
  void note(double command_V, double displacement_in) noexcept;

  /// Fixes the lines; one that is not known, or has less than 0.4 of the assumed gain, is assumed. From here on they
  /// are only compared.
  /// @param extending, retracting  assumed
  void stop_learning(const FlowLine& extending, const FlowLine& retracting) noexcept;

  /// Of extending (0) or retracting (1); none: not known.
  [[nodiscard]] const std::optional<FlowLine>& line(std::size_t direction) const noexcept { return lines_[direction]; }

  [[nodiscard]] const acquisition::Breach& breach() const noexcept { return breach_; }

 private:
  void learn() noexcept;
  void check(std::size_t i) noexcept;
  void trip(const acquisition::Breach& breach) noexcept;

  double period_s_;
  double kept_;  ///< of the sums, each tick of motion
  SlowMotion motion_;
  bool learns_ = true;
  std::array<ForgettingLine, 2> fits_{};  ///< of the speed over the command
  std::array<std::optional<FlowLine>, 2> lines_{};
  std::array<double, 2> missing_in_{};
  std::array<double, 2> due_in_{};
  std::array<double, 2> due_s_{};
  std::array<double, 2> excess_in_{};
  acquisition::Breach breach_;
};

}  // namespace eha::place
