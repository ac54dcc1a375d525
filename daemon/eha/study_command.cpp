// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/new_folders.hpp"
#include "daemon/eha/published_command.hpp"
#include "daemon/eha/study_output.hpp"
#include "daemon/eha/terminal_table.hpp"
#include "daemon/eha/wrapped_text.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "daemon/study/study_page.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;
using study::Cell;
using study::Quartiles;

constexpr int kMostSeeds = 1000;

constexpr const char* kStudyFooter = R"(
Studies of simulated and of published records.)";

constexpr const char* kStudyPaperFooter = R"(
By the paper's procedure a fractional model (FO) gains R2 over an integer one (IO). The study shows how much of this gain
is due to the neglected input bias and to the zero history at the start of each half. It simulates records of four kinds of
plant, 50 s of the paper's tones each: the simulated rig with and without friction, a plant of integer and one of fractional
order. Each record is fitted four times: by the paper's procedure (published), by it after the bias is removed (bias), by the
default procedure without a bias (history), and by the default procedure (both).
Writes study.csv (one row for each record and treatment), study.txt (table and conclusions) and report.html. Uses all
processors; a record takes some 5 s of one.

Example:
  eha study paper --seeds 20 -o study)";

struct StudyCommand {
  int seeds = 10;  ///< records of each kind of plant
  std::filesystem::path output = "study-paper";
};

std::string middle(const Quartiles& q) { return fmt::format("{:.2f}", q.median); }

std::string table_of_cells(const std::vector<Cell>& cells) {
  std::vector<std::vector<std::string>> rows;
  for (const Cell& cell : cells) {
    rows.push_back({std::string(study::plant_kinds()[cell.plant].name), std::string(study::name_of(cell.treatment)),
                    middle(cell.io_r2_percent), middle(cell.fo_r2_percent), fmt::format("{:+.2f}", cell.gain.median),
                    fmt::format("{:+.1f}..{:+.1f}", cell.gain.lower, cell.gain.upper),
                    fmt::format("{}, {}", cell.stable_io, cell.stable_fo)});
  }
  return text_table({{"plant"},
                     {"treatment"},
                     {"IO R2 %", Align::right},
                     {"FO R2 %", Align::right},
                     {"gain", Align::right},
                     {"quartiles", Align::right},
                     {"stable", Align::right}},
                    rows);
}

Json to_json(const Quartiles& q) { return {{"lower", q.lower}, {"median", q.median}, {"upper", q.upper}}; }

Json document_of(const study::PaperStudy& result, const std::vector<Cell>& cells,
                 const std::vector<std::string>& sentences) {
  Json entries = Json::array();
  for (const Cell& cell : cells) {
    entries.push_back({{"plant", study::plant_kinds()[cell.plant].name},
                       {"treatment", study::name_of(cell.treatment)},
                       {"records", cell.records},
                       {"io_r2_percent", to_json(cell.io_r2_percent)},
                       {"fo_r2_percent", to_json(cell.fo_r2_percent)},
                       {"gain_points", to_json(cell.gain)},
                       {"gains_as_printed", cell.gains_as_printed},
                       {"stable_io", cell.stable_io},
                       {"stable_fo", cell.stable_fo},
                       {"fo_highest_order", to_json(cell.fo_order)}});
  }
  Json failures = Json::array();
  for (const study::StudyFailure& failure : result.failures) {
    failures.push_back(
        {{"plant", study::plant_kinds()[failure.plant].name}, {"seed", failure.seed}, {"reason", failure.reason}});
  }
  return {{"schema", "eha-study/1"}, {"seeds", result.seeds},    {"printed_gain_points", study::kPrintedGain},
          {"cells", entries},        {"conclusions", sentences}, {"failures", failures}};
}

ExitCode execute(const StudyCommand& command, Console& console) {
  NewFolders folder(command.output);
  const study::PaperStudy result =
      study::study_paper(command.seeds, identify::thread_executor(), [&](std::size_t done, std::size_t records) {
        console.progress(static_cast<double>(done) / static_cast<double>(records),
                         fmt::format("{} of {} records", done, records));
      });
  console.end_progress();
  for (const study::StudyFailure& failure : result.failures) {
    console.warning(
        fmt::format("{}, seed {}: {}", study::plant_kinds()[failure.plant].title, failure.seed, failure.reason));
  }
  const std::vector<Cell> cells = study::cells_of(result);
  const std::vector<std::string> sentences = study::conclusions(cells);
  std::string text = table_of_cells(cells);
  text +=
      "R2 on the validation half, gain = FO - IO [points]: medians over the\n"
      "records; stable: models of IO, FO. Treatments: eha(1)\n\n";
  for (const std::string& sentence : sentences) text += wrapped(sentence, 0) + "\n";

  write_and_show(console,
                 {.document = document_of(result, cells, sentences),
                  .text = std::move(text),
                  .page = study::page_of(result),
                  .data_name = "study.csv",
                  .data = study::to_csv(result)},
                 command.output);
  return ExitCode::ok;
}

}  // namespace

void add_study(CLI::App& app, ParsedLine& line) {
  CLI::App* study = app.add_subcommand("study", "Study procedures on many simulated or published records");
  study->footer(kStudyFooter);
  study->require_subcommand(1);
  CLI::App* sub = study->add_subcommand("paper", "The paper's procedure and the default one on known plants");
  sub->footer(kStudyPaperFooter);
  auto& command = options_of<StudyCommand>(*sub, line);
  sub->add_option("--seeds", command.seeds, "Records of each kind of plant, 1 to 1000 (default 10)")
      ->type_name("N")
      ->check(CLI::Range(1, kMostSeeds).description(""));
  sub->add_option("-o,--output", command.output, "Folder to write to (default study-paper)")->type_name("DIR");
  add_study_published(*study, line);
}

}  // namespace eha::cli
