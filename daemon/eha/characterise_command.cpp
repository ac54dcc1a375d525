// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "config/measured_check.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/control/client.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/drive_options.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/run_argument.hpp"
#include "daemon/eha/run_command.hpp"
#include "daemon/eha/sheet_answer.hpp"
#include "daemon/report/report.hpp"
#include "daemon/rig/arming.hpp"
#include "daemon/rig/calibration.hpp"
#include "daemon/sheet/run_sheet.hpp"
#include "hal/backends/backend.hpp"

namespace eha::cli {
namespace {

constexpr const char* kCharacteriseFooter = R"(
Measures the valve through the rod: moves the rod to mid-travel, then plays slow triangles and sines for 130 s, while a
slow loop keeps the rod about the middle; at most 180 s with [following]. It is a run like any other: you must have
armed the rig, a real actuator is moved only after your confirmation, every limit of the rig file holds, Ctrl-C ramps
out.
Prints the sheet in the terms of ISO 10770-1 (null, dead band, velocity gain each way, hysteresis, response at 5, 10 and
25 % amplitude, natural frequency, noise), each with its 95 % interval or "not observed", and the lines for rig and
experiment files; writes valve_sheet.json and report.html into the run folder.
With [following] in the rig file, the volts are centred on its null and go beyond its dead band. Without it the middle
of the travel is explored first, at 0.7 mm/s (0.028 in/s), which takes some three minutes more; before a real actuator
moves, the sensor is compared with a ruler's reading (--ruler, or typed in). If a fault ends the run because [following] is
wrong, as of a worn valve, --without-following -o FILE writes the rig file without it, for this measurement; nothing moves.
With RUN, the sheet of an earlier run is computed again; nothing moves.
-o RIG.toml writes the rig file with these numbers in [following], in millimetres where its units are "mm"; all else,
comments too, stays. With RUN it is the file of --local --rig, else that of ehad, else the default one, and the run's own only
where none of them is of its rig. No file is overwritten.

Examples:
  eha arm && eha characterise -o rig-new.toml
  eha characterise --local --fast
  eha characterise --ruler 74mm
  eha characterise runs/20260101T120000Z-characterise)";

struct CharacteriseCommand : DriveOptions {
  std::optional<std::string> run = {};    ///< shows the sheet of this run; nothing moves
  bool without_following = false;         ///< only writes the rig file without [following]; nothing moves
  std::optional<std::string> ruler = {};  ///< position of the rod, a length with its unit; none: asked for if needed
};

/// Never overwrites a rig file.
void require_new(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return;
  throw UsageError(
      fmt::format("{}: exists already, and no rig file is overwritten; name another one with -o", path.string()));
}

/// Returns the rig file of a running service; empty without one.
std::string rig_file_of_service(const std::filesystem::path& socket, const Console& console) {
  std::error_code ignored;
  if (!std::filesystem::exists(socket, ignored)) return {};
  try {
    return control::Client(socket).call("status").at("rig").at("file");
  } catch (const Error& error) {
    console.debug(error.what());
    return {};
  }
}

/// Returns the rig file into which the numbers of a run are written. That of the service, or the one in use without it,
/// as it is now if it is of the same rig: limits and scales of the run's own file may be old, or a stranger's. Then
/// `replaces` stays, else it is emptied.
config::RigConfig rig_to_complete(const sheet::RunSheet& run, NewRigFile& rig_file, const Console& console) {
  const std::string in_use = rig_file.replaces.empty() ? rig_file.completes : rig_file.replaces;
  if (in_use.empty()) return run.rig;
  try {
    config::RigConfig now = config::load_rig(in_use);
    if (now.name == run.rig.name && now.backend.index() == run.rig.backend.index()) {
      if (now.text != run.rig.text) {
        console.info(
            fmt::format("{} has changed since this run: the valve's numbers are written into it as it is now", in_use));
      }
      if (config::measured_rig_check_of(now.backend) != config::measured_rig_check_of(run.rig.backend)) {
        console.warning(fmt::format(
            "{} has another card, other channels or another calibration than this run: with its numbers the "
            "rig is not armed; measure anew: `eha characterise`",
            in_use));
      }
      return now;
    }
    if (rig_file.is_named) {
      throw UsageError(
          fmt::format("--rig {}: it is of the rig \"{}\", and this run is of \"{}\"; name the file of that rig", in_use,
                      now.name, run.rig.name));
    }
    if (rig_file.replaces.empty()) return run.rig;
    console.warning(
        fmt::format("this run is of another rig (\"{}\") than that of {} (\"{}\"), whose file it does not "
                    "replace",
                    run.rig.name, in_use, now.name));
  } catch (const Error& error) {
    if (rig_file.is_named) throw;
    console.warning(fmt::format("{}; the rig file of the run is taken", error.what()));
  }
  rig_file.replaces.clear();
  return run.rig;
}

/// The rig file to write for an earlier run: the named one completed, else that of the service, else the default one.
NewRigFile new_rig_file(const CharacteriseCommand& command, const Console& console) {
  if (command.rig_file) return {.path = command.output, .completes = *command.rig_file, .is_named = true};
  NewRigFile file{
      .path = command.output, .replaces = rig_file_of_service(command.socket, console), .socket = command.socket};
  if (const auto usual = default_rig_file(); file.replaces.empty() && usual) file.completes = usual->string();
  return file;
}

/// What a run tells that late ticks ended: nothing for a rig file.
ExitCode show_cut_sheet(const sheet::RunSheet& run, bool has_rig_file, const DisplayUnit& unit,
                        const Console& console) {
  const std::string why = fmt::format(
      "late ticks ended the run after {:.1f} s: these numbers are of what was measured until then, and none "
      "of them goes into a rig file",
      *run.cut_at_s);
  nlohmann::ordered_json document = sheet::to_json(run);
  document.erase("following");
  document["cut_at_s"] = *run.cut_at_s;
  document["exit_code"] = static_cast<int>(has_rig_file ? ExitCode::bad_data : ExitCode::ok);
  console.print_json(document);
  console.print(sheet::sheet_text(run, unit));
  if (has_rig_file) {
    console.error(why);
  } else {
    console.warning(why);
  }
  console.next_step("eha doctor");
  return has_rig_file ? ExitCode::bad_data : ExitCode::ok;
}

/// Writes the rig file in use without [following], for a measurement that must not use it.
ExitCode write_without_following(const CharacteriseCommand& command, const Console& console) {
  if (command.output.extension() != ".toml") {
    throw UsageError("--without-following: name the file to write, as with -o rig-bare.toml");
  }
  require_new(command.output);
  const std::string of_service = command.local ? std::string() : rig_file_of_service(command.socket, console);
  std::optional<std::string> file = command.rig_file;
  if (!file && !of_service.empty()) file = of_service;
  if (const auto usual = default_rig_file(); !file && usual) file = usual->string();
  if (!file) throw UsageError("no rig file to copy; name one with --local --rig");
  const config::RigConfig used = config::load_rig(*file);
  if (!command.local && of_service.empty() && hal::moves_machine(used.backend)) {
    throw DeviceError(
        fmt::format("no ehad answers at {}, whose rig file this copies and replaces: start it, or name the "
                    "file with --local --rig",
                    command.socket.string()));
  }
  const std::string text = rig_text_without_following(used);
  // What would be put in force must be fit for it.
  if (const auto refusals = arming_findings(config::parse_rig(text, *file)).refusals; !refusals.empty()) {
    throw ConfigError(fmt::format("{}: without [following] it cannot be armed: {}; nothing is written", *file,
                                  fmt::join(refusals, "; ")));
  }
  os::write_file_atomically(command.output, text);
  console.print(fmt::format("written: {}, {} without [following]", command.output.string(), *file));
  console.print_json({{"schema", "eha-rig-file/1"}, {"rig_file", command.output.string()}, {"of", *file}});
  suggest::RigAccess rig = access_of(command);
  if (!command.local) rig.is_disarmed = false;
  if (of_service.empty()) {
    rig.is_local = true;
    rig.is_fast = rig.is_fast || !hal::moves_machine(used.backend);
    rig.socket.clear();
    rig.rig_file = command.output.string();
  }
  const std::string measure = suggest::characterise(rig);
  console.next_step(of_service.empty() ? measure
                                       : put_in_force(command.output, of_service, command.socket) + " && " + measure);
  return ExitCode::ok;
}

}  // namespace

ExitCode show_valve_sheet(const record::OpenRun& opened, SheetFiles wanted, std::optional<NewRigFile> rig_file,
                          const Console& console) {
  sheet::RunSheet run;
  try {
    run = sheet::sheet_of_run(opened, sheet::SheetRuns::cut_as_well);
  } catch (const sheet::RowsMissing& error) {
    console.error(error.what());
    console.next_step("eha doctor");
    return error.exit_code();
  } catch (const DataError& error) {
    console.error(error.what());
    console.next_step("eha plot " + shell_word(opened.path().string()));
    return error.exit_code();
  }
  const DisplayUnit unit = console.unit(run.rig.units);
  if (run.cut_at_s) return show_cut_sheet(run, rig_file.has_value(), unit, console);
  if (rig_file) {
    require_new(rig_file->path);
    os::write_file_atomically(rig_file->path,
                              rig_text_with(rig_to_complete(run, *rig_file, console), sheet::following_of(run)));
    const std::string check = "eha check " + shell_word(rig_file->path.string());
    run.written = {
        rig_file->path.string(),
        rig_file->replaces.empty()
            ? check
            : fmt::format("{} && {}", check, put_in_force(rig_file->path, rig_file->replaces, rig_file->socket))};
  }
  if (wanted == SheetFiles::write) {
    for (const std::string& sentence : sheet::write_sheet(run, unit)) console.warning(sentence);
  }
  std::vector<std::string> files;
  for (const std::string_view name : {sheet::kSheetFile, report::kReportFile}) {
    std::error_code ignored;
    if (std::filesystem::exists(opened.files() / name, ignored)) files.push_back((run.folder / name).string());
  }
  nlohmann::ordered_json document = sheet::to_json(run);
  document["files"] = files;
  if (run.written) document["rig_file"] = run.written->file;
  document["exit_code"] = 0;
  console.print_json(document);
  console.print(sheet::sheet_text(run, unit));
  if (!rig_file) {
    console.print("For the rig file (if ehad runs: eha disarm, then eha reload):\n\n" + sheet::rig_lines(run));
  }
  console.print("\nFor experiment files:\n\n" + sheet::experiment_lines(run));
  if (const std::string warning = sheet::warning_of(run, unit); !warning.empty()) console.warning(warning);
  for (const std::string& file : files) {
    console.info(fmt::format("the {} is in {}", file.ends_with(".html") ? "report" : "sheet", file));
  }
  if (run.written) console.info(fmt::format("written: {}, the rig file with these numbers", run.written->file));
  const std::string show = report_of_run(run.folder, "eha runs show " + shell_word(run.folder.string()));
  if (ident::leak_of(run.sheet)) {  // to be repaired before these numbers are used
    console.next_step(show);
  } else if (sheet::supply_factor(run)) {
    console.info(sheet::next_of(run, console.rig()));
    console.next_step(show);
  } else if (run.written) {
    console.next_step(run.written->command);
  } else if (sheet::is_in_rig_file(run) || sheet::is_written_since(run)) {
    console.info(sheet::next_of(run, console.rig()));
    console.next_step(show);
  } else {
    console.next_step(suggest::sheet_into_rig_file(console.rig(), run.folder.string()));
  }
  return ExitCode::ok;
}

ExitCode execute(const CharacteriseCommand& command, Console& console) {
  if (command.without_following) return write_without_following(command, console);
  const bool writes_rig = command.output.extension() == ".toml";
  if (writes_rig) require_new(command.output);
  if (!writes_rig && !command.local && command.output != DriveOptions{}.output) {
    throw UsageError(
        fmt::format("-o {}: expected a new rig file (.toml), or --local with it", command.output.string()));
  }
  if (command.run) {
    std::optional<NewRigFile> rig_file;
    console.set_rig(access_of_run(*command.run));
    if (writes_rig) rig_file = new_rig_file(command, console);
    return show_valve_sheet(record::OpenRun(*command.run), SheetFiles::keep, rig_file, console);
  }
  RunCommand run{command};
  run.ruler = command.ruler;
  if (writes_rig) {
    run.new_rig_file = command.output;
    run.output = DriveOptions{}.output;
  }
  run.experiment_file = kCharacterising;
  run.text = "schema = 1\nname = \"characterise\"\n\n[characterise]\n";
  return execute(run, console);
}

void add_characterise(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("characterise", "Measure the valve: null, dead band, gains, hysteresis, response");
  sub->footer(kCharacteriseFooter);
  auto& characterise = options_of<CharacteriseCommand>(*sub, line);
  takes_run_name(sub->add_option("run", characterise.run, "Run folder of a characterisation: show its sheet again"),
                 line)
      ->type_name("RUN");
  sub->add_option("--ruler", characterise.ruler,
                  "Where a ruler shows the rod, such as 2.95in or 75mm; needed without [following]")
      ->type_name("LENGTH");
  sub->add_flag("--without-following", characterise.without_following,
                "Only write the rig file without [following] (-o), to measure a valve that it does not describe")
      ->excludes(sub->get_option("run"))
      ->excludes(sub->get_option("--ruler"));
  CLI::Option* local = add_drive_options(*sub, characterise);
  sub->get_option("--output")->remove_needs(local);
  sub->get_option("--output")
      ->description(
          "Rig file (.toml) to write with these numbers; or, with --local, parent of the run folder (default runs)");
}

}  // namespace eha::cli
