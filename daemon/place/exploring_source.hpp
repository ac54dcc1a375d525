// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "daemon/acquisition/command_source.hpp"
#include "daemon/place/centring_source.hpp"
#include "daemon/place/explorer.hpp"
#include "daemon/place/prediction_monitor.hpp"
#include "daemon/place/sheet_pace.hpp"

namespace eha::place {

/// The measurement of a valve of which nothing is known: explores the middle of the travel slowly (Explorer), then
/// plays the table about the null that it found, and no faster than lets the rod stop within the explored travel:
///   1.25 v^2 / a + 0.03 s v <= way to its end;   else loop_speed
/// v the speed [in/s], filtered over 0.02 s, a the rig's deceleration; a scale that is wrong by 2.5 is allowed for. By
/// the gain that exploring has shown, the table moves the rod at 0.5 in/s at most (SheetPace), with the loop at 0.8
/// in/s, and the rod must move as the volts ask (PredictionMonitor). Real-time safe. Not thread-safe.
class ExploringSource final : public acquisition::CommandSource {
 public:
  /// @param table_V   of the plan; must outlive this
  /// @param centring  with a window
  ExploringSource(std::span<const double> table_V, const ident::SheetPlan& plan, const config::Centring& centring,
                  const config::RigLimits& limits, double period_s)
      : explorer_(limits, centring.window_in.value(), period_s),
        pace_(plan, limits.safe_V),
        prediction_(period_s),
        safe_V_(limits.safe_V),
        most_step_V_(limits.slew_V_per_s * period_s),
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
    if (!has_begun_) begin();
    has_begun_ = true;
    check(last.displacement_in);
    prediction_.note(command_V_, last.displacement_in);
    command_V_ = source_.voltage_V(row, last);
    return command_V_;
  }
  [[nodiscard]] Stage stage() const noexcept override { return has_begun_ ? source_.stage() : Stage::preparing; }
  [[nodiscard]] acquisition::Breach breach() const noexcept override {
    if (explorer_.breach().fault != acquisition::Fault::none) return explorer_.breach();
    if (breach_.fault != acquisition::Fault::none) return breach_;
    return prediction_.breach().fault != acquisition::Fault::none ? prediction_.breach() : source_.breach();
  }

 private:
  static constexpr double kFilter_s = 0.02;
  static constexpr double kReaction_s = 0.03;
  static constexpr double kWrongScale = 2.5;
  static constexpr double kSlack_in_per_s = 0.2;  ///< of noise
  static constexpr double kPace_in_per_s = 0.5;   ///< of the table
  static constexpr double kBeyondEdge_in_per_s = 0.1;
  static constexpr double kFastest_in_per_s = 0.8;        ///< of table and loop together
  static constexpr double kUnknownGain_in_per_V_s = 2.0;  ///< where no line was found

  /// Takes over what exploring has shown of the valve.
  void begin() noexcept {
    const double null_V = explorer_.explored().null_V;
    prediction_ = explorer_.monitor();
    command_V_ = null_V;
    // Of a direction that moved at one speed only, the other one's gain.
    const double gain = std::max(gain_of(0), gain_of(1));
    const auto assumed = [&](std::size_t i, double direction) {
      const double slow_V = direction * explorer_.slow_V(i);
      return FlowLine{.gain_in_per_V_s = gain, .edge_V = slow_V - kExploring_in_per_s / gain};
    };
    prediction_.stop_learning(assumed(0, 1.0), assumed(1, -1.0));
    double edge_V = 0.0;
    for (std::size_t i = 0; i < 2; ++i) {
      edge_V = std::max(edge_V, prediction_.line(i)->edge_V - (i == 0 ? null_V : -null_V));
    }
    pace_.bound_by({.edge_V = edge_V + kBeyondEdge_in_per_s / gain, .reach_V = edge_V + kPace_in_per_s / gain});
    source_.set(safe_V_, null_V - safe_V_, edge_V + kFastest_in_per_s / gain, most_step_V_, pace_);
  }

  [[nodiscard]] double gain_of(std::size_t direction) const noexcept {
    const auto& other = explorer_.monitor().line(1 - direction);
    const auto& line = explorer_.monitor().line(direction);
    return line ? line->gain_in_per_V_s : other ? other->gain_in_per_V_s : kUnknownGain_in_per_V_s;
  }

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
  SheetPace pace_;
  PredictionMonitor prediction_;
  double command_V_ = 0.0;
  double safe_V_;
  double most_step_V_;
  double deceleration_in_per_s2_;
  double period_s_;
  CentringSource source_;
  double filtered_in_ = 0.0;
  bool has_begun_ = false;
  acquisition::Breach breach_;
};

}  // namespace eha::place
