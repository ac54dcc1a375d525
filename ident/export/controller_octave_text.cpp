// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/code_text.hpp"
#include "ident/export/controller_formats.hpp"

namespace eha::ident {
namespace {

// Shares the numbers and the tick between the function with its own state and the one that is given its state.
constexpr const char* kNumbersOfScript = R"(
@CONSTANTS@  TAPS = @TAPS@;
  INTEGRAL_POLE = [@IP@];
  INTEGRAL_GAIN = [@IG@];
  DERIVATIVE_POLE = [@DP@];
  DERIVATIVE_GAIN = [@DG@];
)";

constexpr const char* kStart =
    R"(% The reference where the rod is, within the set points; a position that is not finite begins at the first one that is.
    if isfinite(measured), measured = min(max(measured, lowest), highest); else, measured = NaN; end
    c.measured = measured; c.position = measured; c.reference = measured;
    c.set_point = measured;
    c.velocity = 0; c.velocity_sum = 0;
    c.positions = measured * ones(1, TAPS);
    c.velocities = zeros(1, TAPS);
    c.position_sum = measured * TAPS;
    c.at = 1;
    c.filter_1 = 0; c.filter_2 = 0; c.derived = 0;
    c.integral_x = zeros(1, numel(INTEGRAL_POLE));
    c.derivative_x = zeros(1, numel(DERIVATIVE_POLE));
    c.command = min(max(command, command_min), command_max);
    c.is_limited = false;
    c.integral = 0;
    if ki_tick > 0
      off = c.command - valve_null;
      if off > 0, gain = gain_positive; else, gain = gain_negative; end
      speed = off / (1 / gain + dead_band / smoothing);
      if abs(speed) > smoothing, speed = gain * (off - sign(off) * dead_band); end
      c.integral = min(max(speed, -most_speed), most_speed) - position_rate * (measured - rest);
    end)";

constexpr const char* kBegin = R"(
  if ~isfinite(c.measured) && isfinite(measured)
    command = c.command;
    @START@
  end
  if isfinite(c.measured))";

constexpr const char* kTick = R"(
  % Reference generator.
  if ~isfinite(set_point), set_point = c.set_point; end
  target = min(max(set_point, lowest), highest);
  speed = (target - c.set_point) / tick;
  if abs(speed) > velocity_limit, speed = 0; end
  c.set_point = target;
  d = acceleration_limit * tick * tick;
  way = tick * (c.velocity - speed);
  y = c.position - target + way;
  if abs(y) <= d
    a = way + y;
  else
    a = way + 0.5 * sign(y) * (sqrt(d * (d + 8 * abs(y))) - d);
  end
  if abs(a) <= d, wanted = -a / (tick * tick); else, wanted = -acceleration_limit * sign(a); end
  following = min(max(c.velocity + tick * wanted, -velocity_limit), velocity_limit);
  c.position = c.position + tick * c.velocity;
  oldest = c.velocities(c.at);
  c.position_sum = c.position_sum + (c.position - c.positions(c.at));
  c.velocity_sum = c.velocity_sum + (following - oldest);
  c.positions(c.at) = c.position;
  c.velocities(c.at) = following;
  if c.at == TAPS, c.at = 1; else, c.at = c.at + 1; end
  c.velocity = following;
  c.reference = c.position_sum / TAPS;
  velocity = c.velocity_sum / TAPS;
  acceleration = (following - oldest) / (TAPS * tick);

  % Filtered error.
  if isfinite(measured), c.measured = min(max(measured, least_reading), greatest_reading); end
  error_now = c.reference - c.measured;
@FILTER@
  % Feedback and feed-forward: the speed that is asked for.
  derivative = 0;
  if kd > 0
    derived = derivative_direct * error_now + DERIVATIVE_GAIN * c.derivative_x';
    c.derivative_x = DERIVATIVE_POLE .* c.derivative_x + (1 - DERIVATIVE_POLE) * error_now;
    derivative = kd * (derived - c.derived) / tick;
    c.derived = derived;
  end
  asked = position_rate * (c.reference - rest) + velocity_share * velocity + acceleration_s * acceleration ...
          + kp * error_now + c.integral + derivative;
  w = min(max(asked, -most_speed), most_speed);

  % Inverse of the valve, limits.
  if w > 0, gain = gain_positive; else, gain = gain_negative; end
  wanted = valve_null + w / gain + dead_band * min(max(w / smoothing, -1), 1);
  in_range = min(max(wanted, command_min), command_max);
  c.command = min(max(in_range, c.command - slew_tick), c.command + slew_tick);
  off = c.command - valve_null;
  if off > 0, gain = gain_positive; else, gain = gain_negative; end
  given = off / (1 / gain + dead_band / smoothing);
  if abs(given) > smoothing, given = gain * (off - sign(off) * dead_band); end
  lost = given - asked;
  c.is_limited = c.command ~= wanted || w ~= asked;

  % Integrator.
  if ki_tick > 0
    drive = integral_direct * error_now + INTEGRAL_GAIN * c.integral_x';
    c.integral_x = INTEGRAL_POLE .* c.integral_x + (1 - INTEGRAL_POLE) * error_now;
    if ~(c.is_limited && drive * lost < 0) && abs(error_now) >= rest_error
      c.integral = c.integral + ki_tick * drive;
    end
    if c.is_limited, c.integral = c.integral + back * lost; end
  end
)";

constexpr const char* kFilterOfScript = R"(  value = error_now;
  error_now = filter_b * value + c.filter_1;
  c.filter_1 = 2 * filter_b * value - filter_a1 * error_now + c.filter_2;
  c.filter_2 = filter_b * value - filter_a2 * error_now;
)";

constexpr const char* kOctave = R"(function [command_V, c] = @F@(c, @SET_POINT@, @POSITION@)
@NOTES@% c = @F@('start', @POSITION@, command_V) with the command as it stands;
% every tick: [command_V, c] = @F@(c, @SET_POINT@, @POSITION@);
% c.reference is the generated reference, c.is_limited says that a limit changed the command.
@NUMBERS@
  set_point = @SET_POINT@;
  measured = @POSITION@;
  if ischar(c)
    command = measured;
    measured = set_point;
    c = struct();
    @START@
    command_V = c;  % the first output of the start is the state
    return;
  end
@BEGIN@@TICK@  end
  command_V = c.command;
end
)";

constexpr const char* kSimulink =
    R"(function [command_V, @REFERENCE@, is_limited] = @F@(@SET_POINT@, @POSITION@, command_at_start_V)
%#codegen
@NOTES@% For a MATLAB Function block with the tick as its sample time. command_at_start_V is read in the first call only.
% It keeps its state in a persistent variable: one block a model, or copies of the file under other names.
@NUMBERS@
  set_point = @SET_POINT@;
  measured = @POSITION@;
  persistent c
  if isempty(c)
    command = command_at_start_V;
    c = struct('measured', 0, 'position', 0, 'reference', 0, 'set_point', 0, 'velocity', 0, 'velocity_sum', 0, ...
               'positions', zeros(1, TAPS), 'velocities', zeros(1, TAPS), 'position_sum', 0, 'at', 1, ...
               'filter_1', 0, 'filter_2', 0, 'derived', 0, 'integral_x', zeros(1, numel(INTEGRAL_POLE)), ...
               'derivative_x', zeros(1, numel(DERIVATIVE_POLE)), 'command', 0, 'is_limited', false, 'integral', 0);
    @START@
  end
@BEGIN@@TICK@  end
  command_V = c.command;
  @REFERENCE@ = c.reference;
  is_limited = c.is_limited;
end
)";

std::string text_of(const char* shape, const ExportedController& controller, const std::string& function) {
  const AxisCoefficients& c = controller.coefficients;
  std::string notes;
  for (const std::string& line : controller.notes) notes += "% " + line + "\n";
  std::string constants;
  for (const auto& [name, value] : controller_numbers(c)) {
    if (name != "taps") constants += "  " + name + " = " + real_text(value) + ";\n";
  }
  return with_values(shape, {{"NUMBERS", kNumbersOfScript},
                             {"BEGIN", kBegin},
                             {"START", kStart},
                             {"TICK", kTick},
                             {"FILTER", c.has_filter ? kFilterOfScript : ""},
                             {"NOTES", notes},
                             {"CONSTANTS", constants},
                             {"TAPS", std::to_string(c.taps)},
                             {"IP", real_list(c.integral.pole, c.integral.count)},
                             {"IG", real_list(c.integral.gain, c.integral.count)},
                             {"DP", real_list(c.derivative.pole, c.derivative.count)},
                             {"DG", real_list(c.derivative.gain, c.derivative.count)},
                             {"SET_POINT", with_unit("set_point", controller.length_unit)},
                             {"POSITION", with_unit("position", controller.length_unit)},
                             {"REFERENCE", with_unit("reference", controller.length_unit)},
                             {"F", function}});
}

}  // namespace

std::string controller_octave_text(const ExportedController& controller, const std::string& function) {
  return text_of(kOctave, controller, function);
}

std::string controller_simulink_text(const ExportedController& controller, const std::string& function) {
  return text_of(kSimulink, controller, function);
}

}  // namespace eha::ident
