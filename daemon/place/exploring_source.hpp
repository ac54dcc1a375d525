// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "daemon/acquisition/command_source.hpp"
#include "daemon/place/centring_source.hpp"
#include "daemon/place/explorer.hpp"

namespace eha::place {

/// The measurement of a valve of which nothing is known: explores the middle of the travel slowly (Explorer), then
/// plays the table about the null that it found, and no faster than lets the rod stop within the explored travel:
///   1.25 v^2 / a + 0.03 s v <= way to its end;   else loop_speed
/// v the speed [in/s], filtered over 0.02 s, a the rig's deceleration; a scale that is wrong by 2.5 is allowed for.
/// Real-time safe. Not thread-safe.
class ExploringSource final : public acquisition::CommandSource {
 public:
  /// @param table_V   must outlive this
  /// @param centring  with a window
  ExploringSource(std::span<const double> table_V, const config::Centring& centring, const config::RigLimits& limits,
                  double period_s)
      : explorer_(limits, centring.window_in.value(), period_s),
        safe_V_(limits.safe_V),
        deceleration_in_per_s2_(limits.stopping_deceleration_in_per_s2),
        period_s_(period_s),
        source_(table_V, centring, LoopMonitor(loop_bounds(limits), period_s), LearnedMonitor(limits, period_s)) {}

  [[nodiscard]] std::uint32_t rows() const noexcept override { return source_.rows(); }
  [[nodiscard]] std::uint32_t rows_per_repetition() const noexcept override { return source_.rows_per_repetition(); }
  [[nodiscard]] double voltage_V(std::uint32_t row, const hal::RigReading& last) noexcept override {
    if (!explorer_.is_done()) {
      filtered_in_ = last.displacement_in;
      return explorer_.voltage_V(last);
    }
    if (!has_begun_) source_.shift_by(explorer_.explored().null_V - safe_V_);
    has_begun_ = true;
    check(last.displacement_in);
    return source_.voltage_V(row, last);
  }
  [[nodiscard]] Stage stage() const noexcept override { return has_begun_ ? source_.stage() : Stage::preparing; }
  [[nodiscard]] acquisition::Breach breach() const noexcept override {
    if (explorer_.breach().fault != acquisition::Fault::none) return explorer_.breach();
    return breach_.fault != acquisition::Fault::none ? breach_ : source_.breach();
  }

 private:
  static constexpr double kFilter_s = 0.02;
  static constexpr double kReaction_s = 0.03;
  static constexpr double kWrongScale = 2.5;
  static constexpr double kSlack_in_per_s = 0.2;  ///< of noise

  void check(double place_in) noexcept {
    const double speed = (place_in - filtered_in_) / kFilter_s;
    filtered_in_ += period_s_ / (kFilter_s + period_s_) * (place_in - filtered_in_);
    const Explored& explored = explorer_.explored();
    const double way_in = std::max(0.0, speed > 0.0 ? explored.highest_in - place_in : place_in - explored.lowest_in);
    // The root of share v^2 + reaction v = way.
    const double share = 0.5 * kWrongScale / deceleration_in_per_s2_;
    const double allowed = (std::sqrt(kReaction_s * kReaction_s + 4.0 * share * way_in) - kReaction_s) / (2.0 * share);
    const bool is_outside = place_in > explored.highest_in || place_in < explored.lowest_in;
    if ((is_outside || std::abs(speed) > allowed + kSlack_in_per_s) && breach_.fault == acquisition::Fault::none) {
      breach_ = {acquisition::Fault::loop_speed, std::abs(speed), allowed};
    }
  }

  Explorer explorer_;
  double safe_V_;
  double deceleration_in_per_s2_;
  double period_s_;
  CentringSource source_;
  double filtered_in_ = 0.0;
  bool has_begun_ = false;
  acquisition::Breach breach_;
};

}  // namespace eha::place
