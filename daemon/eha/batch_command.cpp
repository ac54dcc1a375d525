// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/os/processors.hpp"
#include "core/program_path.hpp"
#include "core/shell_word.hpp"
#include "core/terminal_text.hpp"
#include "daemon/batch/batch_folder.hpp"
#include "daemon/batch/batch_page.hpp"
#include "daemon/batch/batch_table.hpp"
#include "daemon/batch/next_of_batch.hpp"
#include "daemon/batch/record_list.hpp"
#include "daemon/batch/run_records.hpp"
#include "daemon/batch/table_text.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_line.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/stop_on_signals.hpp"
#include "daemon/eha/terminal_table.hpp"
#include "daemon/eha/wrapped_text.hpp"
#include "ident/model/parameter_text.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBatchFooter = R"(
Fits and judges many records under the same rules, each with `eha fit` in a process of its own, as many at a time as
there are processors. SOURCE is a run folder, a file with a record, a folder of both, or a list: a file *.list with one
path a line. What follows -- are options of `eha fit`; --experiment makes one experiment's rules apply to all.
-o DIR holds batch.json (rules and records), records/ID/ (result.json and the models of each), table.csv and table.json.
After Ctrl-C or a kill the same command continues the batch. Outliers among the records are named ("apart"), and records
whose model is rejected ("left out", with the reason); "spread" gives median and furthest value of each parameter, and the
distance from which on a record lies apart.
--shard I/N fits every N-th record only, for N machines. Parts may share a folder; `eha batch merge` makes their table.
Exit code 0: every record judged, accepted or not; 10: some cannot be read or fitted, the table's text says why.

Examples:
  eha batch runs -o judged
  eha batch pumps/*.csv -o judged -- --model io --decimate 40
  eha batch bench.list -o judged -- --experiment config/experiments/paper.toml
  eha batch runs -o part2 --shard 2/4
  eha batch merge part1 part2 part3 part4 -o judged)";

constexpr const char* kMergeFooter = R"(
Puts the parts of one batch together and writes table.csv and table.json: the same bytes as on one machine.

Examples:
  eha batch merge judged
  eha batch merge part1 part2 -o judged)";

struct BatchCommand {
  std::vector<std::string> sources;  ///< run folders, files, folders of them, lists
  std::filesystem::path output = "batch";
  std::optional<std::size_t> jobs = {};  ///< none: the number of processors
  batch::Shard shard = {};
  std::vector<std::string> fit_options = {};  ///< of `eha fit`: the arguments after --
};

struct BatchMergeCommand {
  std::vector<std::filesystem::path> folders;
  std::optional<std::filesystem::path> output = {};  ///< none: the first folder
};

/// "2/4". @returns whether it is one
bool read_shard(const std::string& text, batch::Shard& shard) {
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) return false;
  const auto read = [](std::string_view part, std::size_t& value) {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc() && end == part.data() + part.size();
  };
  const std::string_view view = text;
  return read(view.substr(0, slash), shard.number) && read(view.substr(slash + 1), shard.count) && shard.number >= 1 &&
         shard.number <= shard.count && shard.count <= 100'000;
}

constexpr std::size_t kMostRowsShown = 40;
constexpr std::size_t kMostNamesShown = 8;  // of what is no record

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

std::string outliers_of(const batch::Row& row, const std::string& common_model) {
  std::string text;
  for (const batch::Outlier& one : row.outliers) text += (text.empty() ? "" : "; ") + batch::outlier_text(one);
  const std::string instead = batch::instead_text(row, common_model);
  return instead.empty() ? text : text + "; " + instead;
}

/// "skipped  2 of runs: notes.md, photo.jpg: no ending of a record (.csv, ...)", a line for each reason and folder.
/// @param output  the folder of the batch, which is no record
std::string skipped_text(const std::vector<batch::Skipped>& skipped, const fs::path& output) {
  std::vector<std::pair<std::string, std::vector<std::string>>> groups;  // by folder and reason
  std::error_code ignored;
  for (const batch::Skipped& one : skipped) {
    const fs::path path = one.source;
    if (fs::equivalent(path, output, ignored)) continue;
    const std::string key = one_line(path.parent_path().string()) + "\n" + one.why;
    auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& known) { return known.first == key; });
    if (group == groups.end()) group = groups.insert(groups.end(), {key, {}});
    group->second.push_back(one_line(path.filename().string()));
  }
  std::string text;
  for (const auto& [key, names] : groups) {
    const std::size_t end = key.find('\n');
    const std::size_t shown = std::min(names.size(), kMostNamesShown);
    text += fmt::format("skipped  {} of {}: {}{}: {}\n", names.size(), key.substr(0, end),
                        fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
                        names.size() > shown ? ", ..." : "", key.substr(end + 1));
  }
  return text;
}

/// @param skipped  lines on what is no record
ExitCode print_table(const batch::BatchFolder& folder, Console& console, const std::string& skipped = {}) {
  const batch::Table stored = batch::table_of(folder);
  const DisplayUnit unit = console.unit(batch::rig_units_of(folder));
  // Each reads every result, which takes longer than the rest of the table.
  const batch::Table table = unit.is_of_record() ? stored : batch::table_of(folder, unit);
  std::vector<fs::path> files = batch::write_table(folder, stored);
  const std::string next = table.missing > 0 ? "eha batch merge PART... -o " + shell_word(folder.path().string())
                                             : batch::next_command(folder, table);
  const report::Page page = batch::page_of(table, next);
  for (const std::string& sentence : page.missing) console.warning(sentence);
  files.push_back(folder.path() / "report.html");
  os::write_file_atomically(files.back(), page.html);
  std::vector<std::vector<std::string>> rows;
  std::size_t failed = 0;
  std::string apart;
  std::string without;
  std::string limits;
  std::string failures;
  for (const batch::Row& row : table.rows) {
    if (row.judged) {
      if (rows.size() < kMostRowsShown) {
        batch::RowFigures figures = row.figures;
        rows.push_back({row.label, row.recommended, batch::grade_of(row), std::move(figures.fit_percent),
                        std::move(figures.error), std::move(figures.form)});
      }
      if (const std::string why = batch::why_none(row); !why.empty()) {
        without += fmt::format("no model {}: {}\n", row.label, why);
      }
      if (const std::string what = batch::what_limits(row); !what.empty() && rows.size() < kMostRowsShown) {
        limits += "usable   " + wrapped(fmt::format("{}: {}", row.label, what), 9) + "\n";
      }
      if (!row.outliers.empty())
        apart += fmt::format("apart    {}: {}\n", row.label, outliers_of(row, table.common_model));
    } else if (row.reason != "no result yet") {
      ++failed;
      failures += fmt::format("failed   {}: exit code {}: {}\n", row.record.source, row.exit_code, row.reason);
    }
  }
  std::string text = text_table(
      {{"record"}, {"recommended"}, {"verdict"}, {"fit %", Align::right}, {"error", Align::right}, {"in figures"}},
      rows);
  if (table.judged > rows.size()) text += fmt::format("and {} more, see table.csv\n", table.judged - rows.size());
  text += fmt::format("records  {} judged, {} failed, {} still open\n", table.judged, failed, table.missing);
  if (table.resolutions.empty()) {
    text += fmt::format("compared nothing: that needs {} records with one model accepted\n", batch::kFewestForOutliers);
  } else {
    text += fmt::format("compared {}\n", table.common_model);
  }
  if (const std::string others = batch::other_units_text(table); !others.empty()) {
    text += fmt::format("units    not compared, in other units: {}\n", others);
  }
  for (const batch::Trend& one : table.trends) {
    text += fmt::format("trend    {} {} from the first record to the last\n", one.parameter, batch::change_text(one));
  }
  if (const std::string note = batch::grade_note(table); !note.empty()) text += "verdict  " + wrapped(note, 9) + "\n";
  text += without + limits;
  for (const batch::NotCompared& one : batch::not_compared(table.rows, table.common_model)) {
    if (!batch::why_none(table.rows[one.row]).empty()) continue;  // said already
    text += fmt::format("{} {}: {}\n", one.in_part ? "in part " : "left out", table.rows[one.row].label, one.reason);
  }
  if (apart.empty() && !table.resolutions.empty()) text += "apart    none of those compared\n";
  text += apart;
  for (const batch::Resolution& one : table.resolutions) {
    text += fmt::format("spread   {}\n", batch::spread_text(table, one));
  }
  if (std::any_of(table.resolutions.begin(), table.resolutions.end(),
                  [](const batch::Resolution& one) { return one.parameter == "dead_band"; })) {
    text += fmt::format("note     {}\n", ident::kDeadBandIs);
  }
  if (table.common_model.starts_with("integrator_lag") && !table.resolutions.empty()) {
    text += fmt::format("note     {}\n", ident::kTimeConstantIs);
  }
  const std::vector<batch::WarningKind> warnings = batch::warning_kinds(table);
  bool has_command = false;
  for (const batch::WarningKind& kind : warnings) {
    text += "warned   " + batch::warning_text(table, kind) + "\n";
    has_command = has_command || kind.text.find('`') != std::string::npos;
  }
  if (has_command) {
    text +=
        "note     a command behind `warned` fits that record alone; for the batch give its options behind --, with "
        "a new folder (-o)\n";
  }
  text += failures + skipped;
  if (failures.find('`') != std::string::npos) {
    text +=
        "note     a command behind `failed` fits that file alone; for the batch write it as a plain record with the "
        "same options (eha import FILE OPTIONS -o NAME.csv) and name NAME.csv in its place, in a new folder (-o)\n";
  }
  for (const fs::path& file : files) text += fmt::format("written: {}\n", file.string());
  console.print_json(batch::to_json(stored));
  console.print(text);
  if (const std::string opens = "xdg-open " + shell_word(files.back().string()); next != opens) {
    console.print("Page: " + opens);
  }
  console.next_step(next);
  return failed > 0 ? ExitCode::bad_data : ExitCode::ok;
}

ExitCode execute(const BatchCommand& command, Console& console) {
  if (command.sources.empty()) throw UsageError("expected records: a folder, files or a list; see `eha batch --help`");
  require_fit_options(command.fit_options);
  batch::FoundRecords found = batch::records_of(command.sources);
  const std::string skipped = skipped_text(found.skipped, command.output);
  batch::BatchFolder folder(command.output, {batch::rules_of(command.fit_options), std::move(found.records)});
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
  return print_table(folder, console, skipped);
}

ExitCode execute(const BatchMergeCommand& command, Console& console) {
  const batch::BatchFolder first(command.folders.front());
  const batch::BatchFolder whole(command.output.value_or(first.path()), first.batch());
  for (const fs::path& part : command.folders) {
    if (part != whole.path()) whole.take_from(batch::BatchFolder(part));
  }
  return print_table(whole, console);
}

}  // namespace

void add_batch(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("batch", "Fit and judge many records under the same rules");
  sub->fallthrough();
  sub->footer(kBatchFooter);
  auto& batch = options_of<BatchCommand>(*sub, line);
  batch.fit_options = line.after_dashes;
  sub->add_option("source", batch.sources, "Run folders, files, folders of them, lists (*.list)")
      ->type_name("SOURCE ...");
  sub->add_option("-o,--output", batch.output, "Folder of the batch (default batch)")->type_name("DIR");
  sub->add_option("--jobs", batch.jobs, "Records at a time (default: the processors)")
      ->type_name("N")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1024}).description(""));
  sub->add_option_function<std::string>(
         "--shard",
         [&batch](const std::string& text) {
           if (!read_shard(text, batch.shard)) {
             throw CLI::ValidationError("--shard", "expected I/N with I from 1 to N, got \"" + text + "\"");
           }
         },
         "Every N-th record only, from the I-th")
      ->type_name("I/N");
  CLI::App* merge = sub->add_subcommand("merge", "Put the parts of a batch together");
  merge->footer(kMergeFooter);
  auto& parts = options_of<BatchMergeCommand>(*merge, line);
  merge->add_option("folder", parts.folders, "Folders of the parts")->required()->type_name("DIR ...");
  merge->add_option("-o,--output", parts.output, "Folder of the whole (default: the first)")->type_name("DIR");
}

}  // namespace eha::cli
