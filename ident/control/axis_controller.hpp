// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <vector>

#include "ident/control/feedback.hpp"

namespace eha::ident {

/// Maps a speed to the valve command that gives it:
///   u = null + w / gain + dead_band clamp(w / smoothing, +-1),   gain that of the sign of w.
/// The smoothing makes the command continuous across the dead band.
struct InverseMap {
  double null = 0.0;           ///< command in the middle of the dead band [V]
  double dead_band = 0.0;      ///< half width [V]
  double gain_positive = 1.0;  ///< speed over command beyond the dead band [in/(V s)]
  double gain_negative = 1.0;  ///< the same for w < 0, positive [in/(V s)]
  double smoothing = 1.0;      ///< speed at which the dead band is bridged fully, positive [in/s]

  bool operator==(const InverseMap&) const = default;

  [[nodiscard]] double command(double w) const noexcept;
  /// Returns the speed that gives a command: the inverse of command().
  [[nodiscard]] double speed(double command) const noexcept;
  /// Greatest slope of command() [V s/in].
  [[nodiscard]] double steepest() const noexcept;
};

/// Bounds of the generated reference.
struct ReferenceLimits {
  double lowest = 0.0;        ///< [in]
  double highest = 0.0;       ///< [in]
  double velocity = 0.0;      ///< positive [in/s]
  double acceleration = 0.0;  ///< positive [in/s^2]
  double jerk = 0.0;          ///< positive [in/s^3]

  /// Readings beyond the set points by more than a tenth of their range are taken as these: no rod is there.
  [[nodiscard]] double least_reading() const noexcept { return lowest - kBeyondSetPoints * (highest - lowest); }
  [[nodiscard]] double greatest_reading() const noexcept { return highest + kBeyondSetPoints * (highest - lowest); }
  static constexpr double kBeyondSetPoints = 0.1;

  bool operator==(const ReferenceLimits&) const = default;
};

/// Speed that the plant needs to follow the reference: position_rate (r - rest) + velocity_share r' + acceleration_s
/// r''.
struct FeedForward {
  double position_rate = 0.0;   ///< of a plant that does not integrate [1/s]
  double rest = 0.0;            ///< position at which it needs no command beyond the null [in]
  double velocity_share = 1.0;  ///< of the reference's velocity; 1: all of it
  double acceleration_s = 0.0;  ///< lag of the plant, its delay and half a tick included [s]

  bool operator==(const FeedForward&) const = default;
};

/// A controller of an axis; lengths in one unit, here [in], commands in [V].
struct AxisSettings {
  double tick_s = 0.001;
  FeedbackKind kind = FeedbackKind::p;
  Feedback feedback;        ///< from the error [in] to the speed [in/s]
  double rest_error = 0.0;  ///< the integrator is held while the filtered error is smaller [in]
  double tracking_s = 0.0;  ///< time constant of the anti-windup back-calculation; used if ki > 0
  double most_speed = 0.0;  ///< greatest speed that the controller requests [in/s]
  InverseMap inverse;
  FeedForward feed_forward;
  ReferenceLimits reference;
  double command_min = 0.0;  ///< [V]
  double command_max = 0.0;  ///< [V]
  double slew_per_s = 0.0;   ///< fastest change of the command [V/s]

  bool operator==(const AxisSettings&) const = default;
};

/// Rational approximation of s^order over a band, as a parallel sum of lags sampled with a held input:
///   direct + sum_i gain_i (1 - pole_i) / (z - pole_i).
/// Oustaloup et al., IEEE Trans. Circuits and Systems I 47 (2000).
struct FractionalFilter {
  static constexpr std::size_t kLags = 9;
  std::size_t count = 0;  ///< of lags; 0: passes its input
  double direct = 1.0;
  std::array<double, kLags> pole{};
  std::array<double, kLags> gain{};
};
/// Within 6 % of s^order two decades below high_rad_s for orders to 0.5, 12 % at 0.7: the filter has
/// no poles above high_rad_s. Margins are computed with the filter, not with the power.
/// @param order  -1 .. 1
[[nodiscard]] FractionalFilter fractional_filter(double order, double low_rad_s, double high_rad_s, double tick_s);

/// Coefficients of one tick of the controller, for this class and for its exports.
struct AxisCoefficients {
  AxisSettings settings;
  double filter_gain = 1.0;  ///< b of b (1 + 2/z + 1/z^2) / (1 + a1/z + a2/z^2); has_filter false: none
  double filter_a1 = 0.0;
  double filter_a2 = 0.0;
  bool has_filter = false;
  FractionalFilter integral = {};    ///< of s^(1 - lambda), before the integrator
  FractionalFilter derivative = {};  ///< of s^(mu - 1), before the difference
  std::size_t taps = 1;              ///< ticks over which the reference is averaged
};
inline constexpr std::size_t kMostTaps = 512;

/// @throws ConfigError  a number that is not finite or out of its range, or a jerk that needs more than kMostTaps
[[nodiscard]] AxisCoefficients coefficients(const AxisSettings& settings);

/// C(z) of the sampled feedback at w, as the controller computes it: the same filter, integrator and difference.
[[nodiscard]] std::complex<double> sampled_feedback(const AxisCoefficients& c, double w_rad_s);

/// Result of one tick.
struct AxisOutput {
  double command = 0.0;       ///< within range and slew [V]
  double reference = 0.0;     ///< generated [in]
  double velocity = 0.0;      ///< of the reference [in/s]
  double acceleration = 0.0;  ///< of the reference [in/s^2]
  bool is_limited = false;    ///< range, slew or speed changed the command
};

/// Follows a set point: reference generator, feed-forward, feedback, inverse of the valve.
///   generator:    time-optimal approach of the set point with bounded velocity and acceleration (Han's fhan), then the
///                 mean over 2 acceleration / jerk, which bounds the jerk
///   feedback:     e = F (r - y)
///                 w = position_rate (r - rest) + velocity_share r' + acceleration_s r'' + kp e + I + kd s^mu e,
///                 |w| <= most_speed
///   command:      u = inverse(w) within range and slew
///   integrator:   I' = ki s^(1 - lambda) e + (speed(u) - w) / tracking_s; the first part is 0 while |e| < rest_error,
///                 and where it would drive a limited command further
/// Real-time safe. Not thread-safe. Cost: about 0.1 us a tick.
/// Han, IEEE Trans. Industrial Electronics 56 (2009), fhan; Astroem and Haegglund, Advanced PID Control (2006), 3.5.
class AxisController {
 public:
  explicit AxisController(const AxisCoefficients& coefficients) noexcept : c_(coefficients) {}

  /// Starts without a bump: the reference at the rod's position, within the set points, the command at its present
  /// value. A position that is not finite starts at the first reading that is; the command stands until then.
  void start(double measured, double command) noexcept;

  /// Computes one tick. Replaces a set point or a reading that is not finite by the one before, and takes a reading far
  /// beyond the set points as the farthest one of ReferenceLimits.
  [[nodiscard]] AxisOutput step(double set_point, double measured) noexcept;

 private:
  struct Lags {
    std::array<double, FractionalFilter::kLags> x{};
    double step(const FractionalFilter& filter, double input) noexcept;
  };
  void generate(double set_point, AxisOutput& out) noexcept;
  double filtered(double error) noexcept;

  AxisCoefficients c_;
  // Generator.
  double set_point_ = 0.0;
  double position_ = 0.0;
  double velocity_ = 0.0;
  std::array<double, kMostTaps> positions_{};
  std::array<double, kMostTaps> velocities_{};
  double position_sum_ = 0.0;
  double velocity_sum_ = 0.0;
  std::size_t at_ = 0;
  // Feedback.
  double measured_ = 0.0;
  double filter_1_ = 0.0;
  double filter_2_ = 0.0;
  Lags integral_lags_;
  Lags derivative_lags_;
  double integral_ = 0.0;
  double derived_ = 0.0;  ///< input of the difference, one tick before
  double command_ = 0.0;
};

}  // namespace eha::ident
