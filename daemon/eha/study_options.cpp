// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/study_options.hpp"

namespace eha::cli {
namespace {

constexpr int kMostSeeds = 1000;

constexpr const char* kStudyFooter = R"(
Studies of simulated records.)";

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

}  // namespace

void add_study(CLI::App& app, StudyCommand& command) {
  CLI::App* study = app.add_subcommand("study", "Study procedures on many simulated records");
  study->footer(kStudyFooter);
  study->require_subcommand(1);
  CLI::App* sub = study->add_subcommand("paper", "The paper's procedure and the default one on known plants");
  sub->footer(kStudyPaperFooter);
  sub->add_option("--seeds", command.seeds, "Records of each kind of plant, 1 to 1000 (default 10)")
      ->type_name("N")
      ->check(CLI::Range(1, kMostSeeds).description(""));
  sub->add_option("-o,--output", command.output, "Folder to write to (default study-paper)")->type_name("DIR");
}

}  // namespace eha::cli
