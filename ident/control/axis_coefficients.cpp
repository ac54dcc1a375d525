// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "ident/control/axis_controller.hpp"

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

/// Width of the fractional filters' band below the frequency of the tick: five decades.
constexpr double kBandShare = 1e-5;
constexpr double kLeast = 1e-9;
constexpr double kMost = 1e9;

void require(bool holds, const char* what, double value) {
  if (!holds) throw ConfigError(fmt::format("controller: {}: got {:g}", what, value));
}

}  // namespace

FractionalFilter fractional_filter(double order, double low_rad_s, double high_rad_s, double tick_s) {
  FractionalFilter filter;
  if (std::abs(order) < 1e-12) return filter;
  // Approximates s^order by n zeros and poles of equal ratio, then partial fractions: all poles are real and distinct.
  constexpr auto n = FractionalFilter::kLags;
  std::array<double, n> zero{};
  std::array<double, n> pole{};
  const double ratio = high_rad_s / low_rad_s;
  for (std::size_t i = 0; i < n; ++i) {
    const double middle = (static_cast<double>(i) + 0.5) / static_cast<double>(n);
    zero[i] = low_rad_s * std::pow(ratio, middle - 0.5 * order / static_cast<double>(n));
    pole[i] = low_rad_s * std::pow(ratio, middle + 0.5 * order / static_cast<double>(n));
  }
  filter.count = n;
  const double direct = std::pow(high_rad_s, order);
  filter.direct = direct;
  for (std::size_t i = 0; i < n; ++i) {
    double residue = direct;
    for (std::size_t j = 0; j < n; ++j) residue *= (zero[j] - pole[i]) / (j == i ? 1.0 : pole[j] - pole[i]);
    // The input of each lag is the mean of the last two readings. With the last one alone a lag would be late by half a
    // tick, which beside the large direct part of a positive order is an error of tens of percent.
    const double q = std::exp(-pole[i] * tick_s);
    const double gain = residue / pole[i];
    filter.pole[i] = q;
    filter.gain[i] = 0.5 * (1.0 + q) * gain;
    filter.direct += 0.5 * (1.0 - q) * gain;
  }
  return filter;
}

AxisCoefficients coefficients(const AxisSettings& s) {
  // Checks that no product or quotient of a tick leaves the range of doubles: the command would not be a number.
  const auto positive = [](double value) { return value >= kLeast && value <= kMost; };
  const auto not_negative = [](double value) { return value >= 0.0 && value <= kMost; };
  const auto finite = [](double value) { return std::abs(value) <= kMost; };
  require(positive(s.tick_s), "tick: expected a positive number of seconds", s.tick_s);
  require(not_negative(s.feedback.kp), "kp: expected 0 or more", s.feedback.kp);
  require(not_negative(s.feedback.ki), "ki: expected 0 or more", s.feedback.ki);
  require(not_negative(s.feedback.kd), "kd: expected 0 or more", s.feedback.kd);
  require(not_negative(s.feedback.filter_s), "filter: expected 0 s or more", s.feedback.filter_s);
  for (const double order : {s.feedback.integral_order, s.feedback.derivative_order}) {
    require(order > 0.0 && order < 2.0, "order: expected a number above 0 and below 2", order);
  }
  require(not_negative(s.rest_error), "rest error: expected 0 or more", s.rest_error);
  require(!(s.feedback.ki > 0.0) || positive(s.tracking_s), "tracking time: expected a positive number of seconds",
          s.tracking_s);
  require(positive(s.most_speed), "greatest speed: expected a positive number", s.most_speed);
  require(finite(s.inverse.null), "null: expected a number", s.inverse.null);
  require(not_negative(s.inverse.dead_band), "dead band: expected 0 or more", s.inverse.dead_band);
  require(positive(s.inverse.gain_positive), "gain: expected a positive number", s.inverse.gain_positive);
  require(positive(s.inverse.gain_negative), "gain: expected a positive number", s.inverse.gain_negative);
  require(positive(s.inverse.smoothing), "smoothing: expected a positive number", s.inverse.smoothing);
  for (const double value : {s.feed_forward.position_rate, s.feed_forward.rest, s.feed_forward.velocity_share,
                             s.feed_forward.acceleration_s, s.reference.lowest}) {
    require(finite(value), "feed-forward: expected a number", value);
  }
  require(finite(s.reference.highest) && s.reference.highest > s.reference.lowest,
          "travel: expected an upper end above the lower one", s.reference.highest);
  require(positive(s.reference.velocity), "velocity: expected a positive number", s.reference.velocity);
  require(positive(s.reference.acceleration), "acceleration: expected a positive number", s.reference.acceleration);
  require(positive(s.reference.jerk), "jerk: expected a positive number", s.reference.jerk);
  require(s.command_max > s.command_min && finite(s.command_max) && finite(s.command_min),
          "command range: expected a maximum above the minimum", s.command_max);
  require(s.command_min < s.inverse.null - s.inverse.dead_band && s.command_max > s.inverse.null + s.inverse.dead_band,
          "command range: expected the null with its dead band inside", s.inverse.null);
  require(positive(s.slew_per_s), "slew: expected a positive number", s.slew_per_s);

  AxisCoefficients c{.settings = s};
  const double taps = std::ceil(2.0 * s.reference.acceleration / s.reference.jerk / s.tick_s - 1e-9);
  require(taps <= static_cast<double>(kMostTaps), "jerk: too small for the acceleration and the tick",
          s.reference.jerk);
  c.taps = static_cast<std::size_t>(std::max(1.0, taps));
  if (s.feedback.filter_s > 0.0) {
    // Bilinear transform of 1 / (1 + s T + (s T)^2 / 2).
    const double k = 2.0 * s.feedback.filter_s / s.tick_s;
    const double a0 = 1.0 + k + 0.5 * k * k;
    c.has_filter = true;
    c.filter_gain = 1.0 / a0;
    c.filter_a1 = (2.0 - k * k) / a0;
    c.filter_a2 = (1.0 - k + 0.5 * k * k) / a0;
  }
  const double high = std::numbers::pi / s.tick_s;
  if (s.feedback.ki > 0.0) {
    c.integral = fractional_filter(1.0 - s.feedback.integral_order, kBandShare * high, high, s.tick_s);
  }
  if (s.feedback.kd > 0.0) {
    c.derivative = fractional_filter(s.feedback.derivative_order - 1.0, kBandShare * high, high, s.tick_s);
  }
  return c;
}

Complex sampled_feedback(const AxisCoefficients& c, double w_rad_s) {
  const AxisSettings& s = c.settings;
  const Complex late = std::polar(1.0, -w_rad_s * s.tick_s);  // 1/z
  const auto fractional = [&](const FractionalFilter& filter) {
    Complex value = filter.direct;
    for (std::size_t i = 0; i < filter.count; ++i) {
      value += filter.gain[i] * (1.0 - filter.pole[i]) * late / (1.0 - filter.pole[i] * late);
    }
    return value;
  };
  Complex value = s.feedback.kp;
  if (s.feedback.ki > 0.0) value += fractional(c.integral) * s.feedback.ki * s.tick_s * late / (1.0 - late);
  if (s.feedback.kd > 0.0) value += fractional(c.derivative) * s.feedback.kd * (1.0 - late) / s.tick_s;
  if (c.has_filter) {
    value *= c.filter_gain * (1.0 + late) * (1.0 + late) / (1.0 + c.filter_a1 * late + c.filter_a2 * late * late);
  }
  return value;
}

}  // namespace eha::ident
