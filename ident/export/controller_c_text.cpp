// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "core/code_text.hpp"
#include "ident/export/controller_formats.hpp"

namespace eha::ident {
namespace {

constexpr const char* kShapeOfC = R"(/*
@NOTES@ *
 * C99, no allocation, no library but libm; include this file, or compile it and copy the declarations:
 *   @F@_controller c;
 *   @F@_start(&c, @POSITION@, command_V);  with the command as it stands
 *   every tick: command_V = @F@_step(&c, @SET_POINT@, @POSITION@);
 */
#include <math.h>

enum { @F@_TAPS = @TAPS@, @F@_INTEGRAL_LAGS = @NI@, @F@_DERIVATIVE_LAGS = @ND@ };

typedef struct {
  double set_point, position, velocity;
  double positions[@F@_TAPS], velocities[@F@_TAPS];
  double position_sum, velocity_sum;
  int at;
  double measured, filter_1, filter_2;
  double integral_x[@F@_INTEGRAL_LAGS + 1], derivative_x[@F@_DERIVATIVE_LAGS + 1];
  double integral, derived, command;
  double reference;  /* of the last tick, for display */
  int is_limited;    /* range, slew or speed changed the last command */
} @F@_controller;

@CONSTANTS@static const double @F@_integral_pole[] = {@IP@};
static const double @F@_integral_gain[] = {@IG@};
static const double @F@_derivative_pole[] = {@DP@};
static const double @F@_derivative_gain[] = {@DG@};

static double @F@_clamp(double value, double low, double high) {
  return value < low ? low : value > high ? high : value;
}

static double @F@_inverse(double w) {
  return @F@_valve_null + w / (w > 0.0 ? @F@_gain_positive : @F@_gain_negative) +
         @F@_dead_band * @F@_clamp(w / @F@_smoothing, -1.0, 1.0);
}

static double @F@_speed(double command) {
  const double off = command - @F@_valve_null;
  const double gain = off > 0.0 ? @F@_gain_positive : @F@_gain_negative;
  const double inside = off / (1.0 / gain + @F@_dead_band / @F@_smoothing);
  if (fabs(inside) <= @F@_smoothing) return inside;
  return gain * (off - copysign(@F@_dead_band, off));
}

static double @F@_lags(const double *pole, const double *gain, int count, double direct, double *x, double input) {
  double value = direct * input;
  int i;
  for (i = 0; i < count; ++i) {
    value += gain[i] * x[i];
    x[i] = pole[i] * x[i] + (1.0 - pole[i]) * input;
  }
  return value;
}

/* Begins without a bump: the reference where the rod is, within the set points, the command where it stands.
 * A position that is not finite begins at the first one that is; the command stands until then. */
void @F@_start(@F@_controller *c, double @POSITION@, double command_V) {
  const double measured = isfinite(@POSITION@) ? @F@_clamp(@POSITION@, @F@_lowest, @F@_highest) : NAN;
  const double command = command_V;
  int i;
  c->measured = c->position = c->reference = c->set_point = measured;
  c->velocity = c->velocity_sum = 0.0;
  for (i = 0; i < @F@_TAPS; ++i) {
    c->positions[i] = measured;
    c->velocities[i] = 0.0;
  }
  c->position_sum = measured * @F@_TAPS;
  c->at = 0;
  c->filter_1 = c->filter_2 = c->derived = 0.0;
  for (i = 0; i <= @F@_INTEGRAL_LAGS; ++i) c->integral_x[i] = 0.0;
  for (i = 0; i <= @F@_DERIVATIVE_LAGS; ++i) c->derivative_x[i] = 0.0;
  c->command = @F@_clamp(command, @F@_command_min, @F@_command_max);
  c->is_limited = 0;
  c->integral = 0.0;
  if (@F@_ki_tick > 0.0) {
    c->integral = @F@_clamp(@F@_speed(c->command), -@F@_most_speed, @F@_most_speed) -
                  @F@_position_rate * (measured - @F@_rest);
  }
}

/* One tick: the command [V]. A set point or a position that is not finite counts as the one before, a position beyond
 * the set points by more than a tenth of their range as the farthest one. */
double @F@_step(@F@_controller *c, double @SET_POINT@, double @POSITION@) {
  const double set_point = @SET_POINT@;
  const double measured = @POSITION@;
  const double h = @F@_tick;
  const double a_most = @F@_acceleration_limit;
  double target, speed, x1, x2, d, way, y, a, wanted, next, oldest, velocity, acceleration;
  double error, derivative = 0.0, asked, w, command, in_range, lost;

  if (!isfinite(c->measured)) {
    if (!isfinite(measured)) return c->command;
    @F@_start(c, measured, c->command);
  }

  /* Reference generator. */
  target = @F@_clamp(isfinite(set_point) ? set_point : c->set_point, @F@_lowest, @F@_highest);
  speed = (target - c->set_point) / h;
  if (fabs(speed) > @F@_velocity_limit) speed = 0.0;
  c->set_point = target;
  x1 = c->position - target;
  x2 = c->velocity - speed;
  d = a_most * h * h;
  way = h * x2;
  y = x1 + way;
  a = fabs(y) <= d ? way + y : way + copysign(0.5, y) * (sqrt(d * (d + 8.0 * fabs(y))) - d);
  wanted = fabs(a) <= d ? -a / (h * h) : -copysign(a_most, a);
  next = @F@_clamp(c->velocity + h * wanted, -@F@_velocity_limit, @F@_velocity_limit);
  c->position += h * c->velocity;
  oldest = c->velocities[c->at];
  c->position_sum += c->position - c->positions[c->at];
  c->velocity_sum += next - oldest;
  c->positions[c->at] = c->position;
  c->velocities[c->at] = next;
  c->at = c->at + 1 == @F@_TAPS ? 0 : c->at + 1;
  c->velocity = next;
  c->reference = c->position_sum / @F@_TAPS;
  velocity = c->velocity_sum / @F@_TAPS;
  acceleration = (next - oldest) / (@F@_TAPS * h);

  /* Filtered error. */
  if (isfinite(measured)) c->measured = @F@_clamp(measured, @F@_least_reading, @F@_greatest_reading);
  error = c->reference - c->measured;
  if (@FILTER@) {
    const double input = error;
    error = @F@_filter_b * input + c->filter_1;
    c->filter_1 = 2.0 * @F@_filter_b * input - @F@_filter_a1 * error + c->filter_2;
    c->filter_2 = @F@_filter_b * input - @F@_filter_a2 * error;
  }

  /* Feedback and feed-forward: the speed that is asked for. */
  if (@F@_kd > 0.0) {
    const double derived = @F@_lags(@F@_derivative_pole, @F@_derivative_gain, @F@_DERIVATIVE_LAGS,
                                    @F@_derivative_direct, c->derivative_x, error);
    derivative = @F@_kd * (derived - c->derived) / h;
    c->derived = derived;
  }
  asked = @F@_position_rate * (c->reference - @F@_rest) + @F@_velocity_share * velocity + @F@_acceleration_s * acceleration +
          @F@_kp * error + c->integral + derivative;
  w = @F@_clamp(asked, -@F@_most_speed, @F@_most_speed);

  /* Inverse of the valve, limits. */
  command = @F@_inverse(w);
  in_range = @F@_clamp(command, @F@_command_min, @F@_command_max);
  c->command = @F@_clamp(in_range, c->command - @F@_slew_tick, c->command + @F@_slew_tick);
  lost = @F@_speed(c->command) - asked;
  c->is_limited = c->command < command || c->command > command || w < asked || w > asked;

  /* Integrator: stands at rest and where it would wind up; goes back with what the limits take away. */
  if (@F@_ki_tick > 0.0) {
    const double drive = @F@_lags(@F@_integral_pole, @F@_integral_gain, @F@_INTEGRAL_LAGS, @F@_integral_direct,
                                  c->integral_x, error);
    if (!(c->is_limited && drive * lost < 0.0) && fabs(error) >= @F@_rest_error) c->integral += @F@_ki_tick * drive;
    if (c->is_limited) c->integral += @F@_back * lost;
  }
  return c->command;
}
)";

}  // namespace

std::string controller_c_text(const ExportedController& controller, const std::string& function) {
  const AxisCoefficients& c = controller.coefficients;
  std::string notes;
  for (const std::string& line : controller.notes) notes += " * " + line + "\n";
  std::string constants;
  for (const auto& [name, value] : controller_numbers(c)) {
    if (name != "taps") constants += "static const double " + function + "_" + name + " = " + real_text(value) + ";\n";
  }
  return with_values(kShapeOfC, {{"NOTES", notes},
                                 {"CONSTANTS", constants},
                                 {"TAPS", std::to_string(c.taps)},
                                 {"NI", std::to_string(c.integral.count)},
                                 {"ND", std::to_string(c.derivative.count)},
                                 {"IP", real_list(c.integral.pole, c.integral.count)},
                                 {"IG", real_list(c.integral.gain, c.integral.count)},
                                 {"DP", real_list(c.derivative.pole, c.derivative.count)},
                                 {"DG", real_list(c.derivative.gain, c.derivative.count)},
                                 {"FILTER", c.has_filter ? "1" : "0"},
                                 {"SET_POINT", with_unit("set_point", controller.length_unit)},
                                 {"POSITION", with_unit("position", controller.length_unit)},
                                 {"F", function}});
}

}  // namespace eha::ident
