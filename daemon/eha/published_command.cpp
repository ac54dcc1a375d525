// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/published_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "daemon/eha/command.hpp"
#include "daemon/eha/new_folders.hpp"
#include "daemon/eha/study_output.hpp"
#include "daemon/eha/terminal_table.hpp"
#include "daemon/eha/wrapped_text.hpp"
#include "daemon/published/published_page.hpp"
#include "daemon/published/published_summary.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;
using published::ScoredTest;
using published::StudiedSet;

constexpr const char* kPublishedFooter = R"(
Climbs the ladder on published records that are below DIR, and scores the recommended model as their publications do,
beside every published figure. No record is shipped: sets that are not there are listed with where to fetch them.
docs/published.md has the protocol and the sources. Writes study.json, study.txt and report.html.
Exit code 10: DIR has no file of any set.

Example:
  eha study published records -o study)";

struct PublishedCommand {
  std::string folder;
  std::filesystem::path output = "study-published";
};

std::string table_of(const StudiedSet& studied, const ScoredTest& scored) {
  std::vector<std::vector<std::string>> rows;
  for (const published::Line& line : published::ranked(studied, scored)) {
    rows.push_back({line.is_ours ? ">" : "", fmt::format("{:.4g}", line.value), line.method, line.source});
  }
  return text_table({{""}, {"score", Align::right}, {"method"}, {"source"}}, rows);
}

std::string text_of(const StudiedSet& studied) {
  std::string text = fmt::format("{}: {}\n", studied.set->name, studied.set->title);
  if (studied.model) text += wrapped(published::model_line(studied), 0) + "\n";
  if (!studied.failure.empty()) text += wrapped("no score: " + studied.failure, 0) + "\n";
  for (const ScoredTest& scored : studied.tests) {
    text += "\n" + wrapped(fmt::format("{}: {}", scored.test->name, published::heading(scored)), 0) + "\n";
    text += table_of(studied, scored);
  }
  return text + "\n";
}

Json json_of(const StudiedSet& studied, const ScoredTest& scored) {
  const published::Test& test = *scored.test;
  Json figures = Json::array();
  for (const published::Figure& figure : test.figures) {
    figures.push_back({{"method", figure.method}, {"value", figure.value}, {"source", figure.source}});
  }
  const auto lines = published::ranked(studied, scored);
  const auto ours = std::find_if(lines.begin(), lines.end(), [](const published::Line& line) { return line.is_ours; });
  return {{"name", test.name},
          {"measure", test.measure.name},
          {"unit", test.unit},
          {"rows", scored.measured.size()},
          {"of_estimating_rows", scored.is_of_estimating_rows},
          {"score", std::isfinite(scored.score) ? Json(scored.score) : Json()},
          {"with_start_fitted", scored.with_start_fitted ? Json(*scored.with_start_fitted) : Json()},
          {"place", ours - lines.begin() + 1},
          {"published", figures}};
}

Json json_of(const StudiedSet& studied) {
  Json set{{"name", studied.set->name}, {"title", studied.set->title}, {"fetch", studied.set->fetch}};
  set["missing_files"] = studied.missing_files;
  if (studied.is_absent()) return set;
  set["failure"] = studied.failure.empty() ? Json() : Json(studied.failure);
  set["model"] = studied.model ? Json(studied.model->name) : Json();
  set["recommended"] = studied.is_recommended;
  if (studied.model && studied.model->verdict) set["grade"] = ident::text(studied.model->verdict->grade);
  set["recommendation"] = studied.recommendation;
  set["estimating_rows"] = studied.estimating_rows;
  set["seconds"] = studied.seconds;
  set["tests"] = Json::array();
  for (const ScoredTest& scored : studied.tests) set["tests"].push_back(json_of(studied, scored));
  return set;
}

std::string text_of(const std::vector<StudiedSet>& study) {
  std::string text;
  std::string absent;
  for (const StudiedSet& studied : study) {
    if (studied.is_absent()) {
      absent += wrapped(fmt::format("{}: {}", studied.set->name, published::absence(studied)), 2) + "\n";
    } else {
      text += text_of(studied);
    }
  }
  if (!absent.empty()) text += "Not there:\n" + absent;
  return text;
}

ExitCode execute(const PublishedCommand& command, Console& console) {
  NewFolders folder(command.output);
  const std::vector<StudiedSet> study =
      published::study_published(published::published_sets(), command.folder, console.progress_callback());
  console.end_progress();
  const std::string text = text_of(study);
  const bool is_empty = std::all_of(study.begin(), study.end(), [](const StudiedSet& s) { return s.is_absent(); });
  Json document{{"schema", "eha-published/1"}, {"sets", Json::array()}};
  for (const StudiedSet& studied : study) document["sets"].push_back(json_of(studied));
  if (is_empty) {
    console.print_json(document);
    console.print(text);
    throw DataError(fmt::format("{}: no file of a published set is below it; fetch one, see the list", command.folder));
  }
  std::string data = document.dump(2) + "\n";
  write_and_show(console,
                 {.document = std::move(document),
                  .text = text,
                  .page = published::page_of(study),
                  .data_name = "study.json",
                  .data = std::move(data)},
                 command.output);
  return ExitCode::ok;
}

}  // namespace

void add_study_published(CLI::App& study, ParsedLine& line) {
  CLI::App* sub = study.add_subcommand("published", "The recommended models on published records");
  sub->footer(kPublishedFooter);
  auto& command = options_of<PublishedCommand>(*sub, line);
  sub->add_option("dir", command.folder, "Folder with the fetched records")->required()->type_name("DIR");
  sub->add_option("-o,--output", command.output, "Folder to write to (default study-published)")->type_name("DIR");
}

}  // namespace eha::cli
