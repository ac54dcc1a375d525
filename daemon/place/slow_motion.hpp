// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::place {

/// Command and speed of a rod in slow motion, both through the same low-pass filter twice, so that they can be
/// compared. Real-time safe; cost: some ten operations a tick. Not thread-safe.
class SlowMotion {
 public:
  /// @param period_s  of the tick
  explicit SlowMotion(double period_s) noexcept : period_s_(period_s), weight_(period_s / (kFilter_s + period_s)) {}

  /// Once a tick. @param command_V  held since the reading before   @param displacement_in  finite
  void note(double command_V, double displacement_in) noexcept {
    if (!has_begun_) {
      has_begun_ = true;
      once_V_ = command_V;
      command_V_ = command_V;
      filtered_in_ = displacement_in;
    }
    once_V_ += weight_ * (command_V - once_V_);
    command_V_ += weight_ * (once_V_ - command_V_);
    const double moved_in = weight_ * (displacement_in - filtered_in_);
    filtered_in_ += moved_in;
    speed_in_per_s_ += weight_ * (moved_in / period_s_ - speed_in_per_s_);
  }

  [[nodiscard]] double command_V() const noexcept { return command_V_; }
  [[nodiscard]] double speed_in_per_s() const noexcept { return speed_in_per_s_; }
  /// By which the second filter of the command follows the first one [V]: the filter's time constant times the slope.
  [[nodiscard]] double trails_by_V() const noexcept { return once_V_ - command_V_; }

 private:
  static constexpr double kFilter_s = 0.05;

  double period_s_;
  double weight_;
  bool has_begun_ = false;
  double once_V_ = 0.0;
  double command_V_ = 0.0;
  double filtered_in_ = 0.0;
  double speed_in_per_s_ = 0.0;
};

}  // namespace eha::place
