// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/valve_options.hpp"

#include "daemon/eha/drive_options.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/eha/service_options.hpp"

namespace eha::cli {
namespace {

constexpr const char* kCharacteriseFooter = R"(
Measures the valve through the rod: moves the rod to mid-travel, then plays slow triangles and sines for 130 s, while a
slow loop keeps the rod about the middle; at most 180 s in all. It is a run like any other: you must have armed the rig, a
real actuator is moved only after your confirmation, every limit of the rig file holds, Ctrl-C ramps out.
Prints the sheet in the terms of ISO 10770-1 (null, dead band, velocity gain each way, hysteresis, response at 5, 10 and
25 % amplitude, natural frequency, noise), each with its 95 % interval or "not observed", and the lines for rig and
experiment files; writes valve_sheet.json and report.html into the run folder.
With [following] in the rig file, the volts are centred on its null and go beyond its dead band; without, they are
centred on the safe voltage. If the following check stops the run because [following] is wrong, comment [following] out
for this run.
With RUN, the sheet of an earlier run is computed again; nothing moves.

Examples:
  eha arm && eha characterise
  eha characterise --local --fast
  eha characterise runs/20260101T120000Z-characterise)";

constexpr const char* kCalibrateFooter = R"(
Finds scale and offset of the displacement sensor from positions measured with a ruler, and moves nothing: place the rod
yourself, by eha goto or with the hydraulics off. Asks for each position and reads the sensor there for 1 s; an empty line
ends. Positions with their voltages, as eha read shows them, can also come from --at or a CSV file. Needs at least 3.
Least squares give scale and offset with standard errors. The residual of each position is shown; a residual beyond the
tolerance is a warning. Writes a new rig file, in which only scale, offset and calibration date differ; comments stay. No
file is overwritten.

Examples:
  eha calibrate
  eha calibrate --rig rig.toml --at 0.5in=0.833 --at 2.95in=4.917 --at 5.4in=9.000
  eha calibrate --rig rig.toml --pairs positions.csv -o rig-new.toml)";

}  // namespace

void add_characterise(CLI::App& app, CharacteriseCommand& characterise) {
  CLI::App* sub = app.add_subcommand("characterise", "Measure the valve: null, dead band, gains, hysteresis, response");
  sub->footer(kCharacteriseFooter);
  sub->add_option("run", characterise.run, "Run folder of a characterisation: show its sheet again")->type_name("RUN");
  add_drive_options(*sub, characterise);
}

void add_calibrate(CLI::App& app, CalibrateCommand& calibrate) {
  CLI::App* sub = app.add_subcommand("calibrate", "Calibrate the displacement sensor with a ruler");
  sub->footer(kCalibrateFooter);
  CLI::Option* at =
      sub->add_option("--at", calibrate.at, "A position and the sensor's voltage there, such as 2.95in=4.917")
          ->type_name("POSITION=VOLTS");
  CLI::Option* pairs = sub->add_option("--pairs", calibrate.pairs_file, "CSV file with position_in and voltage_V")
                           ->type_name("FILE")
                           ->excludes(at);
  CLI::Option* local = sub->add_flag("--local", calibrate.local, "Read the rig in this process, not through ehad");
  local->excludes(at)->excludes(pairs);
  add_socket_option(*sub, calibrate.socket)->excludes(local);
  sub->add_option("--rig", calibrate.rig_file,
                  "Rig file (TOML) to start from (default: the service's, or the default one)")
      ->type_name("RIG");
  sub->add_option("--tolerance", calibrate.tolerance_in, "A residual beyond it is warned of (default 0.02) [in]")
      ->type_name("INCHES")
      ->check(finite_number("a length above 0 in", [](double length) { return length > 0.0; }));
  sub->add_option("-o,--output", calibrate.output, "The new rig file (default beside the old one: NAME-DATE.toml)")
      ->type_name("FILE");
}

}  // namespace eha::cli
