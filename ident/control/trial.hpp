// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "ident/control/axis_controller.hpp"
#include "ident/control/margin_sweep.hpp"

namespace eha::ident {

/// Of the step: within so much of its end the rod is settled.
inline constexpr double kSettledShare = 0.02;

/// A set point at a time, interpolated linearly between two of them.
struct SetPoint {
  double time_s = 0.0;
  double position = 0.0;  ///< [in]
};

/// Set points of a trial of a controller.
struct TrialPlan {
  double step = 0.5;  ///< of the set point [in]
  double sine = 0.2;  ///< amplitude [in]
  double sine_Hz = 0.2;
  int trapezoids = 2;                     ///< pairs of moves, as fast as the reference may move
  std::optional<MarginSweep> sweep = {};  ///< after the trapezoids; none: the margins are not measured
  double hold_s = 60.0;
  double lowest = 0.0;   ///< travel [in]
  double highest = 0.0;  ///< [in]
  /// User's set points in place of step, trapezoids, sine and hold; the first at 0 s, times rising.
  std::vector<SetPoint> reference = {};
};

/// Returns step and sine that suit travel and limits of a controller.
[[nodiscard]] TrialPlan trial_plan(const AxisSettings& settings);

/// What is wrong with a user's set point.
enum class SetPointFault { first_not_at_zero, not_later, outside_travel };

struct BadSetPoint {
  std::size_t index = 0;
  SetPointFault fault = SetPointFault::outside_travel;
};

/// Returns the first set point of a plan that cannot be followed; none if all can. Cost: O(set points).
[[nodiscard]] std::optional<BadSetPoint> bad_set_point(const TrialPlan& plan);

/// Generates the set points of a trial, one a tick: rest, step, trapezoids, sweep, sine, rest, hold; or rest, the
/// user's set points in place of the trapezoids, rest. The step leads towards the middle of the travel. Real-time safe.
class TrialMotion {
 public:
  /// @param plan  outlives this if it has a reference or a sweep
  /// @param home  initial position of the rod [in]
  TrialMotion(const AxisSettings& settings, const TrialPlan& plan, double home) noexcept;

  enum class Part { rest, step, trapezoids, sweep, sine_lead, sine, hold_lead, hold, over };

  /// Independent of the home position.
  [[nodiscard]] std::size_t rows() const noexcept { return ends_.back(); }
  [[nodiscard]] Part part(std::size_t row) const noexcept;
  [[nodiscard]] double set_point(std::size_t row) const noexcept;
  /// Returns the value that is subtracted from the controller's reading; 0 outside the sweep [in].
  [[nodiscard]] double injected(std::size_t row) const noexcept;
  [[nodiscard]] double home() const noexcept { return home_; }
  [[nodiscard]] double way() const noexcept { return way_; }  ///< travel of the step, signed [in]
  [[nodiscard]] double tick_s() const noexcept { return tick_s_; }
  /// Returns the ticks since the part of the trial at this row began.
  [[nodiscard]] std::size_t since(std::size_t row) const noexcept;

 private:
  enum Index : std::size_t {
    kRest,
    kStep,
    kTrapezoids,
    kSweep,
    kSineLead,
    kSine,
    kRestAgain,
    kHoldLead,
    kHold,
    kParts
  };
  [[nodiscard]] std::size_t index(std::size_t row) const noexcept;

  [[nodiscard]] double own_set_point(double time_s) const noexcept;

  std::span<const SetPoint> reference_;
  const MarginSweep* sweep_ = nullptr;
  std::array<std::size_t, kParts> ends_{};  ///< row after each part
  std::size_t move_ = 0;                    ///< ticks of one move
  double home_;
  double way_;
  double sine_;
  double sine_rad_per_tick_;
  double tick_s_;
  double lowest_;   ///< travel [in]
  double highest_;  ///< [in]
};

/// Results of a trial. An error is the generated reference less the rod's position.
struct TrialFigures {
  double following_rms_in = 0.0;  ///< over the trapezoids, rests included
  double following_worst_in = 0.0;
  double sine_rms_in = 0.0;
  double overshoot_in = 0.0;     ///< beyond the step's end
  double settling_s = 0.0;       ///< after the reference has ended, until the error stays within 2 % of the step
  double rest_error_in = 0.0;    ///< greatest size, in the hold after its first 2 s
  double standing_in = 0.0;      ///< peak to peak of the rod over the same time
  double limited_percent = 0.0;  ///< ticks in which range or slew changed the command
  double swings_per_s = 0.0;     ///< most in any second of the command across its null, see SwingCounter
  double travelled_in = 0.0;     ///< path length of the rod in the hold: grows with each oscillation
  bool has_left = false;         ///< the rod left its travel by 0.5 in
};

/// Accumulates the results of a trial row by row.
class TrialScore {
 public:
  explicit TrialScore(const TrialMotion& motion) noexcept : motion_(motion) {}
  /// @param rod  measured or true [in]
  void take(std::size_t row, double reference, double rod) noexcept;
  [[nodiscard]] TrialFigures figures() const noexcept;

 private:
  TrialMotion motion_;
  TrialFigures figures_;
  double ended_s_ = -1.0;
  double settled_s_ = 0.0;
  double trapezoid_square_ = 0.0;
  double trapezoid_rows_ = 0.0;
  double sine_square_ = 0.0;
  double sine_rows_ = 0.0;
  double low_ = std::numeric_limits<double>::infinity();
  double high_ = -std::numeric_limits<double>::infinity();
  double last_ = 0.0;
};

/// Counts the command's swings between above null + width and below null - width over the last second.
/// Real-time safe. Not thread-safe.
class SwingCounter {
 public:
  SwingCounter(double null_V, double width_V, double tick_s) noexcept
      : null_V_(null_V), width_V_(width_V), tick_s_(tick_s) {}
  /// @returns swings in the last second
  int step(double command_V) noexcept;
  /// Most swings that are remembered; more in a second count as kMost.
  static constexpr int kMost = 256;

 private:
  double null_V_;
  double width_V_;
  double tick_s_;
  int side_ = 0;
  double now_s_ = 0.0;
  std::array<double, kMost> at_s_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

/// Returns the width of a swing [V]: half the dead band plus the command needed for noise and speed at rest.
[[nodiscard]] double swing_width_V(const AxisSettings& settings);

}  // namespace eha::ident
