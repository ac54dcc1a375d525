// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/code_text.hpp"
#include "ident/export/controller_formats.hpp"

namespace eha::ident {
namespace {

constexpr const char* kShapeOfPython = R"("""
@NOTES@
    c = @F@(@POSITION@, command_V)  with the command as it stands
    every tick: command_V = c.step(@SET_POINT@, @POSITION@)
"""
import math

@CONSTANTS@TAPS = @TAPS@
HAS_FILTER = @FILTER@
INTEGRAL_POLE = (@IP@,)
INTEGRAL_GAIN = (@IG@,)
DERIVATIVE_POLE = (@DP@,)
DERIVATIVE_GAIN = (@DG@,)


def _clamp(value, low, high):
    return low if value < low else high if value > high else value


def _inverse(w):
    gain = gain_positive if w > 0.0 else gain_negative
    return valve_null + w / gain + dead_band * _clamp(w / smoothing, -1.0, 1.0)


def _speed(command):
    off = command - valve_null
    gain = gain_positive if off > 0.0 else gain_negative
    inside = off / (1.0 / gain + dead_band / smoothing)
    if abs(inside) <= smoothing:
        return inside
    return gain * (off - math.copysign(dead_band, off))


def _lags(pole, gain, direct, x, value):
    result = direct * value
    for i in range(len(pole)):
        result += gain[i] * x[i]
        x[i] = pole[i] * x[i] + (1.0 - pole[i]) * value
    return result


class @F@:
    def __init__(self, @POSITION@, command_V):
        """Begins without a bump: the reference where the rod is, within the set points, the command where it stands.

        A position that is not finite begins at the first one that is; the command stands until then."""
        command = command_V
        measured = _clamp(@POSITION@, lowest, highest) if math.isfinite(@POSITION@) else math.nan
        self.measured = self.position = self.reference = self.set_point = measured
        self.velocity = self.velocity_sum = 0.0
        self.positions = [measured] * TAPS
        self.velocities = [0.0] * TAPS
        self.position_sum = measured * TAPS
        self.at = 0
        self.filter_1 = self.filter_2 = self.derived = 0.0
        self.integral_x = [0.0] * len(INTEGRAL_POLE)
        self.derivative_x = [0.0] * len(DERIVATIVE_POLE)
        self.command = _clamp(command, command_min, command_max)
        self.is_limited = False
        self.integral = 0.0
        if ki_tick > 0.0:
            self.integral = _clamp(_speed(self.command), -most_speed, most_speed) - position_rate * (measured - rest)

    def step(self, @SET_POINT@, @POSITION@):
        """One tick: the command [V]. A set point or a position that is not finite counts as the one before, a position
        beyond the set points by more than a tenth of their range as the farthest one."""
        set_point, measured = @SET_POINT@, @POSITION@
        if not math.isfinite(self.measured):
            if not math.isfinite(measured):
                return self.command
            self.__init__(measured, self.command)
        target = _clamp(set_point if math.isfinite(set_point) else self.set_point, lowest, highest)
        speed = (target - self.set_point) / tick
        if abs(speed) > velocity_limit:
            speed = 0.0
        self.set_point = target
        x2 = self.velocity - speed
        d = acceleration_limit * tick * tick
        way = tick * x2
        y = self.position - target + way
        if abs(y) <= d:
            a = way + y
        else:
            a = way + math.copysign(0.5, y) * (math.sqrt(d * (d + 8.0 * abs(y))) - d)
        wanted = -a / (tick * tick) if abs(a) <= d else -math.copysign(acceleration_limit, a)
        following = _clamp(self.velocity + tick * wanted, -velocity_limit, velocity_limit)
        self.position += tick * self.velocity
        oldest = self.velocities[self.at]
        self.position_sum += self.position - self.positions[self.at]
        self.velocity_sum += following - oldest
        self.positions[self.at] = self.position
        self.velocities[self.at] = following
        self.at = 0 if self.at + 1 == TAPS else self.at + 1
        self.velocity = following
        self.reference = self.position_sum / TAPS
        velocity = self.velocity_sum / TAPS
        acceleration = (following - oldest) / (TAPS * tick)

        if math.isfinite(measured):
            self.measured = _clamp(measured, least_reading, greatest_reading)
        error = self.reference - self.measured
        if HAS_FILTER:
            value = error
            error = filter_b * value + self.filter_1
            self.filter_1 = 2.0 * filter_b * value - filter_a1 * error + self.filter_2
            self.filter_2 = filter_b * value - filter_a2 * error

        derivative = 0.0
        if kd > 0.0:
            derived = _lags(DERIVATIVE_POLE, DERIVATIVE_GAIN, derivative_direct, self.derivative_x, error)
            derivative = kd * (derived - self.derived) / tick
            self.derived = derived
        asked = (position_rate * (self.reference - rest) + velocity_share * velocity + acceleration_s * acceleration
                 + kp * error + self.integral + derivative)
        w = _clamp(asked, -most_speed, most_speed)
        command = _inverse(w)
        in_range = _clamp(command, command_min, command_max)
        self.command = _clamp(in_range, self.command - slew_tick, self.command + slew_tick)
        lost = _speed(self.command) - asked
        self.is_limited = self.command != command or w != asked

        if ki_tick > 0.0:
            drive = _lags(INTEGRAL_POLE, INTEGRAL_GAIN, integral_direct, self.integral_x, error)
            if not (self.is_limited and drive * lost < 0.0) and abs(error) >= rest_error:
                self.integral += ki_tick * drive
            if self.is_limited:
                self.integral += back * lost
        return self.command
)";

}  // namespace

std::string controller_python_text(const ExportedController& controller, const std::string& function) {
  const AxisCoefficients& c = controller.coefficients;
  std::string notes;
  for (const std::string& line : controller.notes) notes += line + "\n";
  std::string constants;
  for (const auto& [name, value] : controller_numbers(c)) {
    if (name != "taps") constants += name + " = " + real_text(value) + "\n";
  }
  return with_values(kShapeOfPython, {{"NOTES", notes},
                                      {"CONSTANTS", constants},
                                      {"TAPS", std::to_string(c.taps)},
                                      {"IP", real_list(c.integral.pole, c.integral.count)},
                                      {"IG", real_list(c.integral.gain, c.integral.count)},
                                      {"DP", real_list(c.derivative.pole, c.derivative.count)},
                                      {"DG", real_list(c.derivative.gain, c.derivative.count)},
                                      {"FILTER", c.has_filter ? "True" : "False"},
                                      {"SET_POINT", with_unit("set_point", controller.length_unit)},
                                      {"POSITION", with_unit("position", controller.length_unit)},
                                      {"F", function}});
}

}  // namespace eha::ident
