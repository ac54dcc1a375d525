// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <string>
#include <system_error>

#include "core/os/files.hpp"
#include "daemon/eha/commands.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_header.hpp"
#include "daemon/report/display.hpp"
#include "daemon/report/report.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;

bool is_folder(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
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

}  // namespace

ExitCode execute(const ReportCommand& command, Console& console) {
  const bool is_run = is_folder(command.sources.front());
  fs::path path = command.output.value_or(is_run ? fs::path(command.sources.front()) / report::kReportFile
                                                 : fs::path(report::kReportFile));
  std::string of_rig;
  if (record::is_run_folder(command.sources.front())) {
    of_rig = record::rig_units(record::to_json(record::read_manifest(command.sources.front())));
  }
  const DisplayUnit unit = console.unit(of_rig);
  std::vector<std::string> missing;
  if (is_run && !command.output && command.sources.size() == 1) {
    missing = report::write_into_run(command.sources.front(), unit);
  } else {
    const report::Page page = report::page_of(report::in_unit(load(command), unit));
    os::write_file_atomically(path, page.html);
    missing = page.missing;
  }
  for (const std::string& sentence : missing) console.warning(sentence);
  console.print_json({{"schema", "eha-report/1"}, {"file", path.string()}, {"missing_plots", missing}});
  console.print(fmt::format("written: {}", path.string()));
  console.next_step(fmt::format("xdg-open {}", path.string()));
  return ExitCode::ok;
}

}  // namespace eha::cli
