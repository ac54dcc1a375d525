// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/control/axis_controller.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace eha::ident {
namespace {

double sign(double value) noexcept { return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : 0.0; }

/// Returns the acceleration that takes (x1, x2) of x1' = x2, x2' = a to zero in least time with |a| <= most, without
/// chatter at the step h (Han's fhan).
double approach(double x1, double x2, double most, double h) noexcept {
  const double d = most * h * h;
  const double way = h * x2;
  const double y = x1 + way;
  const double root = std::sqrt(d * (d + 8.0 * std::abs(y)));
  const double a = std::abs(y) <= d ? way + y : way + 0.5 * sign(y) * (root - d);
  return std::abs(a) <= d ? -a / (h * h) : -most * sign(a);
}

}  // namespace

double InverseMap::command(double w) const noexcept {
  return null + w / (w > 0.0 ? gain_positive : gain_negative) + dead_band * std::clamp(w / smoothing, -1.0, 1.0);
}

double InverseMap::speed(double command) const noexcept {
  const double off = command - null;
  const double gain = off > 0.0 ? gain_positive : gain_negative;
  const double inside = off / (1.0 / gain + dead_band / smoothing);
  if (std::abs(inside) <= smoothing) return inside;
  return gain * (off - std::copysign(dead_band, off));
}

double InverseMap::steepest() const noexcept {
  return 1.0 / std::min(gain_positive, gain_negative) + dead_band / smoothing;
}

void AxisController::start(double measured, double command) noexcept {
  const AxisSettings& s = c_.settings;
  measured = std::isfinite(measured) ? std::clamp(measured, s.reference.lowest, s.reference.highest)
                                     : std::numeric_limits<double>::quiet_NaN();
  measured_ = measured;
  set_point_ = measured;
  position_ = measured;
  velocity_ = 0.0;
  for (std::size_t i = 0; i < c_.taps; ++i) {
    positions_[i] = measured;
    velocities_[i] = 0.0;
  }
  position_sum_ = measured * static_cast<double>(c_.taps);
  velocity_sum_ = 0.0;
  at_ = 0;
  filter_1_ = 0.0;
  filter_2_ = 0.0;
  integral_lags_ = {};
  derivative_lags_ = {};
  derived_ = 0.0;
  command_ = std::clamp(command, s.command_min, s.command_max);
  integral_ = s.feedback.ki > 0.0 ? std::clamp(s.inverse.speed(command_), -s.most_speed, s.most_speed) -
                                        s.feed_forward.position_rate * (measured - s.feed_forward.rest)
                                  : 0.0;
}

void AxisController::generate(double set_point, AxisOutput& out) noexcept {
  const ReferenceLimits& limits = c_.settings.reference;
  const double h = c_.settings.tick_s;
  const double target = std::clamp(std::isfinite(set_point) ? set_point : set_point_, limits.lowest, limits.highest);
  // A jump of the set point has no speed to follow.
  double speed = (target - set_point_) / h;
  if (std::abs(speed) > limits.velocity) speed = 0.0;
  set_point_ = target;
  const double wanted = approach(position_ - target, velocity_ - speed, limits.acceleration, h);
  const double next = std::clamp(velocity_ + h * wanted, -limits.velocity, limits.velocity);
  position_ += h * velocity_;
  const double oldest_velocity = velocities_[at_];
  position_sum_ += position_ - positions_[at_];
  velocity_sum_ += next - oldest_velocity;
  positions_[at_] = position_;
  velocities_[at_] = next;
  at_ = at_ + 1 == c_.taps ? 0 : at_ + 1;
  velocity_ = next;
  const auto taps = static_cast<double>(c_.taps);
  out.reference = position_sum_ / taps;
  out.velocity = velocity_sum_ / taps;
  out.acceleration = (next - oldest_velocity) / (taps * h);
}

double AxisController::filtered(double error) noexcept {
  if (!c_.has_filter) return error;
  const double b = c_.filter_gain;
  const double value = b * error + filter_1_;
  filter_1_ = 2.0 * b * error - c_.filter_a1 * value + filter_2_;
  filter_2_ = b * error - c_.filter_a2 * value;
  return value;
}

double AxisController::Lags::step(const FractionalFilter& filter, double input) noexcept {
  double value = filter.direct * input;
  for (std::size_t i = 0; i < filter.count; ++i) {
    value += filter.gain[i] * x[i];
    x[i] = filter.pole[i] * x[i] + (1.0 - filter.pole[i]) * input;
  }
  return value;
}

AxisOutput AxisController::step(double set_point, double measured) noexcept {
  const AxisSettings& s = c_.settings;
  const double h = s.tick_s;
  AxisOutput out;
  if (!std::isfinite(measured_)) {
    out.command = command_;
    out.reference = measured_;
    if (!std::isfinite(measured)) return out;
    start(measured, command_);
  }
  generate(set_point, out);
  if (std::isfinite(measured)) {
    measured_ = std::clamp(measured, s.reference.least_reading(), s.reference.greatest_reading());
  }
  const double error = filtered(out.reference - measured_);

  double derivative = 0.0;
  if (s.feedback.kd > 0.0) {
    const double derived = derivative_lags_.step(c_.derivative, error);
    derivative = s.feedback.kd * (derived - derived_) / h;
    derived_ = derived;
  }
  const double asked = s.feed_forward.position_rate * (out.reference - s.feed_forward.rest) +
                       s.feed_forward.velocity_share * out.velocity + s.feed_forward.acceleration_s * out.acceleration +
                       s.feedback.kp * error + integral_ + derivative;
  const double w = std::clamp(asked, -s.most_speed, s.most_speed);
  const double wanted = s.inverse.command(w);
  const double step = s.slew_per_s * h;
  const double in_range = std::clamp(wanted, s.command_min, s.command_max);
  out.command = std::clamp(in_range, command_ - step, command_ + step);
  command_ = out.command;
  const double lost = s.inverse.speed(out.command) - asked;  // speed that the limits remove
  out.is_limited = out.command < wanted || out.command > wanted || w < asked || w > asked;

  if (s.feedback.ki > 0.0) {
    const double drive = integral_lags_.step(c_.integral, error);
    const bool is_winding = out.is_limited && drive * lost < 0.0;
    if (!is_winding && std::abs(error) >= s.rest_error) integral_ += h * s.feedback.ki * drive;
    if (out.is_limited) integral_ += h / s.tracking_s * lost;
  }
  return out;
}

}  // namespace eha::ident
