// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "daemon/eha/command.hpp"
#include "daemon/eha/commands.hpp"
#include "daemon/eha/drive_options.hpp"
#include "daemon/eha/run_command.hpp"
#include "daemon/eha/valve_sheet.hpp"
#include "daemon/report/report.hpp"
#include "daemon/sheet/run_sheet.hpp"

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

struct CharacteriseCommand : DriveOptions {
  std::optional<std::string> run = {};  ///< shows the sheet of this run; nothing moves
};

/// To which the following check wants the null known, see FOLLOWING in eha-rig(5) [V].
constexpr double kWantedNull_V = 0.03;

}  // namespace

ExitCode show_valve_sheet(const std::filesystem::path& folder, SheetFiles wanted, const Console& console) {
  const sheet::RunSheet run = sheet::sheet_of_run(folder);
  const DisplayUnit unit = console.unit(run.rig.units);
  if (wanted == SheetFiles::write) {
    for (const std::string& sentence : sheet::write_sheet(run, unit)) console.warning(sentence);
  }
  std::vector<std::string> files;
  for (const std::string_view name : {sheet::kSheetFile, report::kReportFile}) {
    std::error_code ignored;
    if (std::filesystem::exists(run.folder / name, ignored)) files.push_back((run.folder / name).string());
  }
  nlohmann::ordered_json document = sheet::to_json(run);
  document["files"] = files;
  document["exit_code"] = 0;
  console.print_json(document);
  console.print(sheet::sheet_text(run, unit));
  console.print("For the rig file (if ehad runs: eha disarm, then eha reload):\n\n" + sheet::rig_lines(run));
  console.print("\nFor experiment files:\n\n" + sheet::experiment_lines(run));
  if (run.sheet.null_V.half_width > kWantedNull_V) {
    console.warning(fmt::format(
        "the null is known to +-{:.3f} V only, the following check needs {:g} V: with so much leakage or noise the "
        "check may stop a sound rig; repair the seal or the sensor, or widen dead_band_V by as much",
        run.sheet.null_V.half_width, kWantedNull_V));
  }
  for (const std::string& file : files) console.info(fmt::format("the sheet is in {}", file));
  console.next_step("eha check RIG.toml");
  return ExitCode::ok;
}

ExitCode execute(const CharacteriseCommand& command, Console& console) {
  if (command.run) return show_valve_sheet(*command.run, SheetFiles::keep, console);
  RunCommand run{command};
  run.experiment_file = "characterise";
  run.text = "schema = 1\nname = \"characterise\"\n\n[characterise]\n";
  return execute(run, console);
}

void add_characterise(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("characterise", "Measure the valve: null, dead band, gains, hysteresis, response");
  sub->footer(kCharacteriseFooter);
  auto& characterise = options_of<CharacteriseCommand>(*sub, line);
  sub->add_option("run", characterise.run, "Run folder of a characterisation: show its sheet again")->type_name("RUN");
  add_drive_options(*sub, characterise);
}

}  // namespace eha::cli
