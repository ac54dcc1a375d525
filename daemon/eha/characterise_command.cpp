// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "daemon/eha/commands.hpp"
#include "daemon/eha/valve_sheet.hpp"
#include "daemon/report/report.hpp"
#include "daemon/sheet/run_sheet.hpp"

namespace eha::cli {
namespace {

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

}  // namespace eha::cli
