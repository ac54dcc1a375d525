// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <optional>
#include <string>
#include <system_error>

#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/controller_argument.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/run_argument.hpp"
#include "daemon/eha/track_report.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_header.hpp"
#include "daemon/report/display.hpp"
#include "daemon/report/report.hpp"
#include "daemon/sheet/run_sheet.hpp"
#include "daemon/track/track_result.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kReportFooter = R"(
Writes one HTML page that needs no other file and prints on A4: the recommended model and why, all models, measured and
simulated output with errors, frequency response, stability, residual, valve map, parameter intervals, timing and
provenance. A note beside each plot says what this record shows, what a good one looks like, and what to do.
A run's page goes to RUN/report.html, where `eha run` and `eha fit RUN` write it too; of model files to ./report.html.
With fit.csv and frequency_response.csv in the models' folder (`eha fit -o`) their plots are included.
The plots are drawn by gnuplot (Debian package gnuplot-nox); without it the page has none and says so.

Examples:
  eha report runs/latest
  eha report models/io.json models/fo.json -o comparison.html)";

struct ReportCommand {
  std::vector<std::string> sources;                  ///< one run folder, or model files
  std::optional<std::filesystem::path> output = {};  ///< none: report.html, in the run folder of a run
};

bool is_folder(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

/// Whether a folder is a controller's trial that can be held to its promise. One that ended early gets its rows, where
/// they are missing, for the report of the run.
bool is_complete_trial(const record::OpenRun& run) {
  const record::Manifest manifest = record::read_manifest(run.files());
  if (record::purpose_of(manifest) != record::Purpose::tracking) return false;
  if (manifest.outcome == acquisition::Outcome::completed) return fs::exists(run.files() / track::kTrackRows);
  if (manifest.outcome && !fs::exists(run.files() / track::kTrackRows)) {
    try {
      track::write_ended_track(run);
    } catch (const Error&) {
      return false;  // nothing was recorded, or the folder is another user's; the page says what there is
    }
  }
  return false;
}

/// The valve sheet of a folder that is a run of [characterise]; none where its rows do not tell the valve.
std::optional<sheet::RunSheet> sheet_in(const record::OpenRun& run) {
  if (record::purpose_of(record::read_manifest(run.files())) != record::Purpose::valve_sheet) return std::nullopt;
  try {
    return sheet::sheet_of_run(run);
  } catch (const DataError&) {
    return std::nullopt;  // the page of the run says so
  }
}

report::Subject load(const ReportCommand& command) {
  if (command.sources.size() == 1 && is_folder(command.sources.front()))
    return report::load_run(command.sources.front());
  for (const std::string& source : command.sources) {
    if (is_folder(source)) {
      throw UsageError(fmt::format("{}: a report is about one run or about model files; give the run alone", source));
    }
  }
  return report::load_models({command.sources.begin(), command.sources.end()});
}

ExitCode execute(const ReportCommand& command, Console& console) {
  const bool is_run = is_folder(command.sources.front());
  if (is_run && !command.output) {
    require_writable_run(command.sources.front(), "eha report " + shell_word(command.sources.front()), "report.html");
  }
  const bool is_controller = command.sources.size() == 1 && is_controller_file(command.sources.front());
  fs::path path = command.output.value_or(is_run ? fs::path(command.sources.front()) / report::kReportFile
                                                 : fs::path(report::kReportFile));
  std::optional<record::OpenRun> run;
  std::string of_rig;
  fs::path target = path;
  if (record::is_run_folder(command.sources.front())) {
    run.emplace(command.sources.front());
    of_rig = record::rig_units(record::to_json(record::read_manifest(run->files())));
    if (!command.output) target = run->files() / report::kReportFile;
    if (command.sources.size() > 1) run.reset();
  }
  const DisplayUnit unit = console.unit(of_rig);
  std::vector<std::string> missing;
  if (is_controller) {
    if (!command.output) path = fs::path(command.sources.front()).replace_extension(".html");
    tune::ControllerSubject subject = controller_subject(config::load_controller(command.sources.front()));
    if (!subject.inputs) {
      console.warning(
          fmt::format("{}: its model or rig file is no longer there, or has changed; the plots are left out",
                      command.sources.front()));
    }
    subject.rig = for_a_page(access_of_controller(command.sources.front(), subject.controller));
    subject.unit = console.unit(rig_units_of_controller(subject.controller));
    subject.dated = written_words(command.sources.front());
    const report::Page page = tune::controller_page(subject);
    os::write_file_atomically(path, page.html);
    missing = page.missing;
  } else if (run && is_complete_trial(*run)) {
    const report::Page page = track_page(track::track_result(*run), unit);
    os::write_file_atomically(target, page.html);
    missing = page.missing;
  } else if (const auto sheet = run ? sheet_in(*run) : std::nullopt) {
    os::write_file_atomically(target, sheet::sheet_page(*sheet, unit, missing));
  } else if (run && !command.output) {
    missing = report::write_into_run(*run, unit);
  } else {
    const report::Page page = report::page_of(report::in_unit(run ? report::load_run(*run) : load(command), unit));
    os::write_file_atomically(path, page.html);
    missing = page.missing;
  }
  for (const std::string& sentence : missing) console.warning(sentence);
  console.print_json({{"schema", "eha-report/1"}, {"file", path.string()}, {"missing_plots", missing}});
  console.print(fmt::format("written: {}", path.string()));
  console.next_step("xdg-open " + shell_word(path.string()));
  return ExitCode::ok;
}

}  // namespace

void add_report(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("report", "Write a report with plots of a run or of models");
  sub->footer(kReportFooter);
  auto& report = options_of<ReportCommand>(*sub, line);
  takes_run_name(sub->add_option("sources", report.sources, "Run folder, or model files (JSON)"), line)
      ->required()
      ->type_name("RUN|MODEL...");
  sub->add_option("-o,--output", report.output, "File to write")->type_name("FILE.html");
}

}  // namespace eha::cli
