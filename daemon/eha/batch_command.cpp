// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/os/processors.hpp"
#include "core/program_path.hpp"
#include "daemon/batch/batch_page.hpp"
#include "daemon/batch/record_list.hpp"
#include "daemon/batch/run_records.hpp"
#include "daemon/batch/table.hpp"
#include "daemon/eha/command_line.hpp"
#include "daemon/eha/commands.hpp"
#include "daemon/eha/stop_on_signals.hpp"
#include "daemon/eha/text_table.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostRowsShown = 40;

/// @throws UsageError  `eha fit` does not know these options
void require_fit_options(const std::vector<std::string>& options) {
  std::vector<const char*> words{"eha", "fit", "RECORD"};
  for (const std::string& option : options) {
    if (option == "-o" || option.starts_with("--output") || option == "--json") {
      throw UsageError(fmt::format("{}: the batch sets this option itself; give the batch's folder before --", option));
    }
    words.push_back(option.c_str());
  }
  try {
    (void)parse_command_line(static_cast<int>(words.size()), words.data());
  } catch (const UsageError& error) {
    throw UsageError(fmt::format("after --: {}", error.what()));
  }
}

std::string outliers_of(const batch::Row& row) {
  std::string text;
  for (const batch::Outlier& one : row.outliers) {
    text += fmt::format("{}{} {:.4g}, more than {:.2g} from the median {:.4g}", text.empty() ? "" : "; ", one.parameter,
                        one.value, one.half_width, one.median);
  }
  return text;
}

ExitCode print_table(const batch::BatchFolder& folder, Console& console) {
  const batch::Table table = batch::table_of(folder);
  std::vector<fs::path> files = batch::write_table(folder, table);
  const report::Page page = batch::page_of(table);
  for (const std::string& sentence : page.missing) console.warning(sentence);
  files.push_back(folder.path() / "report.html");
  os::write_file_atomically(files.back(), page.html);
  std::vector<std::vector<std::string>> rows;
  std::size_t failed = 0;
  std::string apart;
  std::string failures;
  for (const batch::Row& row : table.rows) {
    if (row.judged) {
      if (rows.size() < kMostRowsShown) rows.push_back({row.record.id, row.recommended, batch::grade_of(row)});
      if (!row.outliers.empty()) apart += fmt::format("apart    {}: {}\n", row.record.id, outliers_of(row));
    } else if (row.reason != "no result yet") {
      ++failed;
      failures += fmt::format("failed   {}: exit code {}: {}\n", row.record.source, row.exit_code, row.reason);
    }
  }
  std::string text = text_table({{"record"}, {"recommended"}, {"grade"}}, rows);
  if (table.judged > rows.size()) text += fmt::format("and {} more, see table.csv\n", table.judged - rows.size());
  text += fmt::format("records  {} judged, {} failed, {} still open\n", table.judged, failed, table.missing);
  if (!table.common_model.empty()) text += fmt::format("compared {}\n", table.common_model);
  for (const batch::Trend& one : table.trends) {
    text += fmt::format("trend    {} {} from the first record to the last\n", one.parameter, batch::change_text(one));
  }
  text += apart + failures;
  for (const fs::path& file : files) text += fmt::format("written: {}\n", file.string());
  console.print_json(batch::to_json(table));
  console.print(text);
  if (table.missing > 0) console.next_step(fmt::format("eha batch merge PART... -o {}", folder.path().string()));
  return failed > 0 ? ExitCode::bad_data : ExitCode::ok;
}

}  // namespace

ExitCode execute(const BatchCommand& command, Console& console) {
  if (command.sources.empty()) throw UsageError("expected records: a folder, files or a list; see `eha batch --help`");
  require_fit_options(command.fit_options);
  batch::BatchFolder folder(command.output, {batch::rules_of(command.fit_options), batch::records_of(command.sources)});
  StopOnSignals signals(Driver::service);
  const auto progress = console.progress_callback();
  const std::size_t jobs = command.jobs.value_or(os::usable_processors());
  const bool complete = batch::run_records(
      folder,
      {.program = find_program("eha"), .jobs = jobs, .shard = command.shard, .progress = progress, .stopped = [&] {
         return signals.count() > 0;
       }});
  console.end_progress();
  if (!complete) {
    console.warning(fmt::format("interrupted: {} records are still open; the same command goes on with them",
                                folder.open_records(command.shard).size()));
    return ExitCode::interrupted;
  }
  return print_table(folder, console);
}

ExitCode execute(const BatchMergeCommand& command, Console& console) {
  const batch::BatchFolder first(command.folders.front());
  const batch::BatchFolder whole(command.output.value_or(first.path()), first.batch());
  for (const fs::path& part : command.folders) {
    if (part != whole.path()) whole.take_from(batch::BatchFolder(part));
  }
  return print_table(whole, console);
}

}  // namespace eha::cli
