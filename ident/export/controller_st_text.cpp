// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/code_text.hpp"
#include "ident/export/controller_formats.hpp"

namespace eha::ident {
namespace {

constexpr const char* kShapeOfBlock = R"((*
@NOTES@Call it in a cyclic task of that period. Manual hands ManualCommand_V through, within the limits; it begins again without a bump
where Manual ends. Hold keeps the reference where it is.
*)
FUNCTION_BLOCK @F@
VAR_INPUT
  @SET_POINT@ : LREAL;
  @ACTUAL@ : LREAL;
  Manual : BOOL;
  ManualCommand_V : LREAL;
  Hold : BOOL;
END_VAR
VAR_OUTPUT
  Command_V : LREAL;
  @REFERENCE@ : LREAL;  (* generated *)
  Limited : BOOL;         (* range, slew or speed changed the command *)
END_VAR
VAR
  Started : BOOL := FALSE;
  Measured : LREAL;  (* the reading that counts *)
  SetPointBefore : LREAL;
  Position : LREAL;
  Velocity : LREAL;
  Positions : ARRAY [0..@LAST_TAP@] OF LREAL;
  Velocities : ARRAY [0..@LAST_TAP@] OF LREAL;
  PositionSum : LREAL;
  VelocitySum : LREAL;
  Slot : DINT := 0;
  Filter1 : LREAL;
  Filter2 : LREAL;
  IntegralPart : LREAL;
  Derived : LREAL;
  Commanded : LREAL;
  IntegralX : ARRAY [0..@LAST_I@] OF LREAL;
  DerivativeX : ARRAY [0..@LAST_D@] OF LREAL;
  IntegralPole : ARRAY [0..@LAST_I@] OF LREAL := [@IP@];
  IntegralGain : ARRAY [0..@LAST_I@] OF LREAL := [@IG@];
  DerivativePole : ARRAY [0..@LAST_D@] OF LREAL := [@DP@];
  DerivativeGain : ARRAY [0..@LAST_D@] OF LREAL := [@DG@];
@CONSTANTS@  i : DINT;
  Target : LREAL;
  Speed : LREAL;
  D : LREAL;
  Way : LREAL;
  Y : LREAL;
  A : LREAL;
  Wanted : LREAL;
  Following : LREAL;
  Oldest : LREAL;
  RefVelocity : LREAL;
  RefAcceleration : LREAL;
  Error : LREAL;
  Value : LREAL;
  DerivativePart : LREAL;
  Asked : LREAL;
  W : LREAL;
  Gain : LREAL;
  Off : LREAL;
  Given : LREAL;
  Lost : LREAL;
  Drive : LREAL;
END_VAR

(* No comparison holds for a reading that is no number: it counts as the one before. One beyond the set points by more
   than a tenth of their range counts as the farthest one. *)
IF @ACTUAL@ > c_greatest_reading THEN
  Measured := c_greatest_reading;
ELSIF @ACTUAL@ < c_least_reading THEN
  Measured := c_least_reading;
ELSIF (@ACTUAL@ >= c_least_reading) AND (@ACTUAL@ <= c_greatest_reading) THEN
  Measured := @ACTUAL@;
ELSIF NOT Started THEN
  Command_V := LIMIT(c_command_min, ManualCommand_V, c_command_max);
  Limited := FALSE;
  RETURN;
END_IF;

IF Manual OR NOT Started THEN
  IF NOT Started THEN
    Commanded := LIMIT(c_command_min, ManualCommand_V, c_command_max);
  END_IF;
  Wanted := LIMIT(c_command_min, ManualCommand_V, c_command_max);
  Commanded := LIMIT(Commanded - c_slew_tick, Wanted, Commanded + c_slew_tick);
  Position := LIMIT(c_lowest, Measured, c_highest);
  SetPointBefore := Position;
  Velocity := 0.0;
  VelocitySum := 0.0;
  FOR i := 0 TO @LAST_TAP@ DO
    Positions[i] := Position;
    Velocities[i] := 0.0;
  END_FOR;
  PositionSum := Position * @TAPS_REAL@;
  Slot := 0;
  Filter1 := 0.0;
  Filter2 := 0.0;
  Derived := 0.0;
  FOR i := 0 TO @LAST_I@ DO
    IntegralX[i] := 0.0;
  END_FOR;
  FOR i := 0 TO @LAST_D@ DO
    DerivativeX[i] := 0.0;
  END_FOR;
  IntegralPart := 0.0;
  IF c_ki_tick > 0.0 THEN
    Off := Commanded - c_valve_null;
    Gain := SEL(Off > 0.0, c_gain_negative, c_gain_positive);
    Given := Off / (1.0 / Gain + c_dead_band / c_smoothing);
    IF ABS(Given) > c_smoothing THEN
      Given := Gain * (Off - SEL(Off > 0.0, -c_dead_band, c_dead_band));
    END_IF;
    IntegralPart := LIMIT(-c_most_speed, Given, c_most_speed) - c_position_rate * (Position - c_rest);
  END_IF;
  Started := TRUE;
  Command_V := Commanded;
  @REFERENCE@ := Position;
  Limited := FALSE;
  IF Manual THEN
    RETURN;
  END_IF;
END_IF;

(* Reference generator. *)
Target := SetPointBefore;
IF NOT Hold THEN
  Target := LIMIT(c_lowest, @SET_POINT@, c_highest);
END_IF;
Speed := (Target - SetPointBefore) / c_tick;
IF ABS(Speed) > c_velocity_limit THEN
  Speed := 0.0;
END_IF;
SetPointBefore := Target;
D := c_acceleration_limit * c_tick * c_tick;
Way := c_tick * (Velocity - Speed);
Y := Position - Target + Way;
IF ABS(Y) <= D THEN
  A := Way + Y;
ELSE
  A := Way + SEL(Y > 0.0, -0.5, 0.5) * (SQRT(D * (D + 8.0 * ABS(Y))) - D);
END_IF;
IF ABS(A) <= D THEN
  Wanted := -A / (c_tick * c_tick);
ELSE
  Wanted := SEL(A > 0.0, c_acceleration_limit, -c_acceleration_limit);
END_IF;
Following := LIMIT(-c_velocity_limit, Velocity + c_tick * Wanted, c_velocity_limit);
Position := Position + c_tick * Velocity;
Oldest := Velocities[Slot];
PositionSum := PositionSum + (Position - Positions[Slot]);
VelocitySum := VelocitySum + (Following - Oldest);
Positions[Slot] := Position;
Velocities[Slot] := Following;
Slot := Slot + 1;
IF Slot > @LAST_TAP@ THEN
  Slot := 0;
END_IF;
Velocity := Following;
@REFERENCE@ := PositionSum / @TAPS_REAL@;
RefVelocity := VelocitySum / @TAPS_REAL@;
RefAcceleration := (Following - Oldest) / (@TAPS_REAL@ * c_tick);

(* Filtered error. *)
Error := @REFERENCE@ - Measured;
@FILTER@
(* Feedback and feed-forward: the speed that is asked for. *)
DerivativePart := 0.0;
IF c_kd > 0.0 THEN
  Value := c_derivative_direct * Error;
  FOR i := 0 TO @LAST_D@ DO
    Value := Value + DerivativeGain[i] * DerivativeX[i];
    DerivativeX[i] := DerivativePole[i] * DerivativeX[i] + (1.0 - DerivativePole[i]) * Error;
  END_FOR;
  DerivativePart := c_kd * (Value - Derived) / c_tick;
  Derived := Value;
END_IF;
Asked := c_position_rate * (@REFERENCE@ - c_rest) + c_velocity_share * RefVelocity + c_acceleration_s * RefAcceleration
         + c_kp * Error + IntegralPart + DerivativePart;
W := LIMIT(-c_most_speed, Asked, c_most_speed);

(* Inverse of the valve, limits. *)
Gain := SEL(W > 0.0, c_gain_negative, c_gain_positive);
Wanted := c_valve_null + W / Gain + c_dead_band * LIMIT(-1.0, W / c_smoothing, 1.0);
Commanded := LIMIT(Commanded - c_slew_tick, LIMIT(c_command_min, Wanted, c_command_max), Commanded + c_slew_tick);
Off := Commanded - c_valve_null;
Gain := SEL(Off > 0.0, c_gain_negative, c_gain_positive);
Given := Off / (1.0 / Gain + c_dead_band / c_smoothing);
IF ABS(Given) > c_smoothing THEN
  Given := Gain * (Off - SEL(Off > 0.0, -c_dead_band, c_dead_band));
END_IF;
Lost := Given - Asked;
Limited := (Commanded <> Wanted) OR (W <> Asked);

(* Integrator: stands at rest and where it would wind up; goes back with what the limits take away. *)
IF c_ki_tick > 0.0 THEN
  Drive := c_integral_direct * Error;
  FOR i := 0 TO @LAST_I@ DO
    Drive := Drive + IntegralGain[i] * IntegralX[i];
    IntegralX[i] := IntegralPole[i] * IntegralX[i] + (1.0 - IntegralPole[i]) * Error;
  END_FOR;
  IF NOT (Limited AND (Drive * Lost < 0.0)) AND (ABS(Error) >= c_rest_error) THEN
    IntegralPart := IntegralPart + c_ki_tick * Drive;
  END_IF;
  IF Limited THEN
    IntegralPart := IntegralPart + c_back * Lost;
  END_IF;
END_IF;
Command_V := Commanded;
END_FUNCTION_BLOCK
)";

constexpr const char* kFilterOfBlock = R"(Value := Error;
Error := c_filter_b * Value + Filter1;
Filter1 := 2.0 * c_filter_b * Value - c_filter_a1 * Error + Filter2;
Filter2 := c_filter_b * Value - c_filter_a2 * Error;
)";

std::string last_index(std::size_t count) { return std::to_string(count > 0 ? count - 1 : 0); }

}  // namespace

std::string controller_st_text(const ExportedController& controller, const std::string& function) {
  const AxisCoefficients& c = controller.coefficients;
  std::string notes;
  for (const std::string& line : controller.notes) notes += line + "\n";
  std::string constants;
  for (const auto& [name, value] : controller_numbers(c)) {
    if (name != "taps") constants += "  c_" + name + " : LREAL := " + real_text(value) + ";\n";
  }
  return with_values(kShapeOfBlock, {{"NOTES", notes},
                                     {"CONSTANTS", constants},
                                     {"LAST_TAP", last_index(c.taps)},
                                     {"TAPS_REAL", real_text(static_cast<double>(c.taps))},
                                     {"LAST_I", last_index(c.integral.count)},
                                     {"LAST_D", last_index(c.derivative.count)},
                                     {"IP", real_list(c.integral.pole, c.integral.count)},
                                     {"IG", real_list(c.integral.gain, c.integral.count)},
                                     {"DP", real_list(c.derivative.pole, c.derivative.count)},
                                     {"DG", real_list(c.derivative.gain, c.derivative.count)},
                                     {"FILTER", c.has_filter ? kFilterOfBlock : ""},
                                     {"SET_POINT", with_unit("SetPoint", controller.length_unit)},
                                     {"ACTUAL", with_unit("Actual", controller.length_unit)},
                                     {"REFERENCE", with_unit("Reference", controller.length_unit)},
                                     {"F", function}});
}

}  // namespace eha::ident
