// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/capitalised.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/comparison_answer.hpp"
#include "daemon/eha/controller_argument.hpp"
#include "daemon/eha/exported_origin.hpp"
#include "daemon/eha/import_options.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/eha/model_options.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/option_values.hpp"
#include "daemon/eha/run_argument.hpp"
#include "daemon/eha/terminal_table.hpp"
#include "daemon/identify/comparison.hpp"
#include "daemon/identify/exchange_check.hpp"
#include "daemon/identify/intersample_check.hpp"
#include "daemon/identify/record_units.hpp"
#include "daemon/identify/scored_model.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/plot/gnuplot.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/report/comparison_page.hpp"
#include "daemon/report/figures.hpp"
#include "daemon/sheet/compared_sheets.hpp"
#include "ident/model/model_file.hpp"
#include "ident/model/parameter_name.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/output_unit.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kCompareFooter = R"(
Runs (or other records): fits one integer-order model behind a valve map to each, on the same samples with the same
criteria. Shows the changes from the first run to each other one with joint intervals: at most 1 % false alarms for all
parameters and runs together.
Models and one record: scores each model on the record and fits its structure to it (refit). A model is of another plant,
whatever its R2, if its parameters differ from the refit's and its error is more than 1.5 times the refit's. The report
draws the record with each model's output and error.
Models alone: compares their parameters.
-o FILE.html writes a before/after report: what changed, both records and errors over time, Bode plots over one another;
.svg, .png or .pdf draws the Bode plots alone.
--period, --input and the other options on files hold for every file that is named; --from and --to for runs, too.

Examples:
  eha compare runs/20261122T101500Z-paper runs/latest -o changes.html
  eha compare before.csv after.csv --input "Valve [V]" --output "Rod [mm]" --from 2
  eha compare models/io.json models/fo.json record.csv -o bode.svg)";

struct CompareCommand {
  std::vector<std::string> sources;                    ///< run folders and records, or model files (.json)
  std::optional<ident::Intersample> intersample = {};  ///< of files
  importer::Options import = {};                       ///< of every file
  std::optional<std::filesystem::path> output = {};    ///< report (.html), or picture of the Bode plots
};

bool is_model(const std::string& path) { return std::filesystem::path(path).extension() == ".json"; }

/// ", null -0.2 V, half dead band 0.15 V": what gain and phase do not show. Empty without a map.
std::string map_text(const ident::Model& model) {
  std::string text;
  for (const ident::ParameterEstimate& p : model.parameters) {
    if (p.role != ident::ParameterRole::valve_null && p.role != ident::ParameterRole::dead_band) continue;
    text +=
        fmt::format(", {} {:.3g}{}", ident::shown_name(p.role, p.name), p.value, ident::after_number(model.input_unit));
  }
  return text;
}

/// Draws gain and phase of the models over one another.
void draw_bode(const std::vector<std::pair<std::string, const ident::Model*>>& models,
               const std::filesystem::path& path) {
  std::vector<report::ReportedModel> labelled;
  for (const auto& [label, model] : models) {
    labelled.push_back({*model, label});
    labelled.back().model.name = label + map_text(*model);
  }
  std::vector<const report::ReportedModel*> drawn;
  for (const report::ReportedModel& model : labelled) drawn.push_back(&model);
  std::string names;
  for (const auto& [label, model] : models) names += (names.empty() ? "" : ", ") + label;
  const plot::Figure figure = report::bode_figure(drawn, nullptr, "gain and phase: " + names);
  const std::string ending = path.extension().string();
  const plot::Format format = ending == ".png"   ? plot::Format::png
                              : ending == ".pdf" ? plot::Format::pdf
                                                 : plot::Format::svg;
  os::write_file_atomically(path, plot::draw(figure, format));
}

/// A model estimated on the record that scores it is of its plant, however badly it describes it.
std::vector<identify::ScoredModel> without_own_record(std::vector<identify::ScoredModel> scored,
                                                      const std::vector<ident::Model>& models,
                                                      const identify::Source& source) {
  const std::string record = source.run_folder ? source.run_folder->string() : source.name;
  for (std::size_t i = 0; i < scored.size(); ++i) {
    if (!is_one_record(record_of(models[i]), record)) continue;
    scored[i].of_another_plant = false;
    scored[i].cannot_tell.clear();
  }
  return scored;
}

/// Warns of a run that is named twice: it never differs from itself.
void warn_of_one_run_twice(const std::vector<identify::Source>& sources, const Console& console) {
  std::error_code ignored;
  for (std::size_t i = 1; i < sources.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (!sources[i].run_folder || !sources[k].run_folder) continue;
      const std::filesystem::path folder = std::filesystem::canonical(*sources[i].run_folder, ignored);
      if (folder.empty() || folder != std::filesystem::canonical(*sources[k].run_folder, ignored)) continue;
      console.warning(fmt::format(
          "{} and {} are the same run, {}. latest is the last run with an accepted model; name a later one, "
          "`eha runs` lists them",
          sources[k].name, sources[i].name, folder.filename().string()));
    }
  }
}

/// The valve sheets of runs of [characterise]; none where one of the records is none, which is said.
std::vector<sheet::RunSheet> sheets_of(const std::vector<std::string>& records, const Console& console) {
  std::vector<std::string> others;
  for (const std::string& record : records) {
    const bool is_sheet = record::is_run_folder(record) &&
                          record::purpose_of(record::read_manifest(record)) == record::Purpose::valve_sheet;
    if (!is_sheet) others.push_back(record);
  }
  if (!others.empty() && others.size() < records.size()) {
    console.warning(
        fmt::format("{} {} no run of [characterise], the other is: their experiments differ, so that a difference need "
                    "not be the plant's; compare two valve sheets, or two runs of one experiment",
                    fmt::join(others, " and "), others.size() == 1 ? "is" : "are"));
  }
  if (!others.empty()) return {};
  std::vector<sheet::RunSheet> sheets;
  for (const std::string& record : records) sheets.push_back(sheet::sheet_of_run(record));
  return sheets;
}

ExitCode compare_valves(const std::vector<sheet::RunSheet>& sheets, const CompareCommand& command, Console& console) {
  const sheet::ComparedSheets compared = sheet::compare_sheets(sheets, console.unit(sheets.front().rig.units));
  console.set_rig(access_of_run(sheets[compared.measured_again].folder));
  std::string text = compared.heading + "\n";
  for (const std::string& sentence : compared.sentences) text += sentence + "\n";
  for (std::size_t i = 0; i < compared.quantities.size(); ++i) {
    text += fmt::format("\n{}:\n", compared.names[i + 1]) + text_table({{"quantity"},
                                                                        {"before", Align::right},
                                                                        {"after", Align::right},
                                                                        {"difference", Align::right},
                                                                        {"joint +-", Align::right},
                                                                        {"unit"},
                                                                        {"changed"}},
                                                                       sheet::rows_of(compared.quantities[i]));
  }
  nlohmann::ordered_json document = sheet::to_json(compared);
  if (command.output) {
    if (command.output->extension() != ".html") {
      throw UsageError(
          fmt::format("-o {}: valve sheets are compared in a table; name a page (.html)", command.output->string()));
    }
    const report::Page page = sheet::page_of(compared);
    os::write_file_atomically(*command.output, page.html);
    document["file"] = command.output->string();
    text += fmt::format("written: {}\n", command.output->string());
  }
  console.print_json(document);
  console.print(text);
  return ExitCode::ok;
}

/// How one of the records is read. The options are of the files: a run's columns are known.
importer::Options import_of(const std::string& record, const std::vector<std::string>& records,
                            const importer::Options& given) {
  const auto is_run = [](const std::string& path) {
    std::error_code ignored;
    return std::filesystem::is_directory(path, ignored);
  };
  importer::Options options = given;
  const bool has_file = !std::all_of(records.begin(), records.end(), is_run);
  if (is_run(record) && has_file) {
    options = {.from_s = given.from_s, .to_s = given.to_s};
  } else if (!importer::says_how_to_read(given)) {
    // What one file lacks need not hold for the others: it is answered by a copy of that one.
    options.then = std::exchange(options.command, {});
  }
  return options;
}

/// What goes on where the plant of a record has changed: a model of that record; on a rig whose valve changed, the
/// measurement of the valve.
void say_next_of_change(const identify::Source& source, const std::string& name, bool changes_valve,
                        const CompareCommand& command, const std::optional<ident::Intersample>& intersample,
                        const Console& console) {
  if (source.run_folder && changes_valve) {
    console.next_step(suggest::characterise(access_of_run(*source.run_folder)));
  } else if (source.run_folder && command.output) {
    return;  // its page shows more than the run's own
  } else if (source.run_folder) {
    console.next_step(report_of_run(*source.run_folder, "eha fit " + shell_word(name)));
  } else {
    console.next_step(fmt::format("eha fit {}{}{} -o {}", shell_word(name),
                                  importer::words_of_reading(command.import.command), intersample_words(intersample),
                                  shell_word(free_name("models"))));
  }
}

/// Takes the input of the files among the records as straight between their rows where they show it.
/// @returns whether they do
bool take_files_as_straight(std::vector<identify::Source>& sources, const identify::RunComparison& held) {
  std::vector<const ident::Model*> models;
  for (const identify::ComparedRun& run : held.runs) models.push_back(&run.fit.model);
  if (!identify::are_straight(sources, models)) return false;
  for (identify::Source& source : sources) {
    if (!source.run_folder) identify::take_input_as_straight(source);
  }
  return true;
}

const std::vector<std::string> kEndings{".html", ".svg", ".png", ".pdf"};

/// An earlier version took --output for the file to write, and no column has such a name.
CompareCommand as_meant(CompareCommand command) {
  if (command.output || !command.import.output) return command;
  const std::string ending = std::filesystem::path(*command.import.output).extension().string();
  if (std::find(kEndings.begin(), kEndings.end(), ending) == kEndings.end()) return command;
  command.output = *command.import.output;
  command.import.output.reset();
  return command;
}

ExitCode execute(const CompareCommand& given, Console& console) {
  const CompareCommand command = as_meant(given);
  std::vector<std::string> files;
  std::vector<std::string> records;
  for (const std::string& source : command.sources) (is_model(source) ? files : records).push_back(source);
  const bool understood =
      files.empty() ? records.size() >= 2 : records.size() <= 1 && files.size() + records.size() >= 2;
  if (!understood) {
    throw UsageError(
        "expected two or more runs (eha compare BEFORE AFTER), or models and one record (eha compare MODEL.json... "
        "DATA), or two or more models");
  }
  if (records.empty() && importer::says_how_to_read(command.import)) {
    throw UsageError("models alone have no columns and no rows; name the record, too, or leave out " +
                     importer::words_of_reading(command.import.command).substr(1) + " (-o names the file to write)");
  }
  if (const std::vector<sheet::RunSheet> sheets =
          files.empty() ? sheets_of(records, console) : std::vector<sheet::RunSheet>();
      !sheets.empty()) {
    return compare_valves(sheets, command, console);
  }
  std::vector<ident::Model> models;
  for (const std::string& file : files) models.push_back(ident::model_from_text(os::read_file(file), file));
  std::vector<identify::Source> sources;
  // Of models: whose input was straight between the rows, and the record so.
  std::vector<bool> takes_straight;
  std::optional<identify::Source> straight;
  for (const std::string& record : records) {
    sources.push_back(
        identify::load_source(record, {}, import_of(record, records, command.import), console.progress_callback()));
    sources.back().opened = {};  // nothing is written there, and a process has a limited number of descriptors
    if (command.intersample == ident::Intersample::straight) identify::take_input_as_straight(sources.back());
    if (command.intersample || files.empty() || sources.back().run_folder) continue;
    const auto is_straight = [&](const ident::Model& model) {
      return intersample_for({}, model, console) == ident::Intersample::straight;
    };
    for (const ident::Model& model : models) takes_straight.push_back(is_straight(model));
    if (std::find(takes_straight.begin(), takes_straight.end(), true) == takes_straight.end()) continue;
    straight = sources.back();
    identify::take_input_as_straight(*straight);
  }
  console.end_progress();
  if (!sources.empty()) {
    const auto& run = sources.back().run_folder;
    console.set_rig(run ? access_of_run(*run) : access_of_file());
  }
  warn_of_one_run_twice(sources, console);
  // Of several records these are among the notes of the comparison.
  for (const std::string& sentence : files.empty() ? std::vector<std::string>() : identify::named_warnings(sources)) {
    console.warning(sentence);
  }
  for (const std::string& file : files) {
    if (!sources.empty()) warn_of_own_record(file, sources.front(), console);
  }

  for (std::size_t i = 0; i < models.size() && !sources.empty(); ++i) {
    models[i] = identify::in_units_of(sources.front(), std::move(models[i]), files[i]);
  }
  if (sources.empty()) models = identify::in_units_of_first(std::move(models), files);

  const DisplayUnit unit = console.unit(sources.empty() ? rig_units_of_model(files.front()) : sources.front().units);
  std::vector<ident::Model> shown_models;
  for (const ident::Model& model : models) shown_models.push_back(in_unit(model, unit));
  // The document keeps the records' unit; text, picture and report use the display unit.
  Json document;
  Compared shown;
  std::optional<identify::RunComparison> runs;
  bool are_files_straight = false;
  std::optional<std::string> exchange;  ///< the command that exchanges input and output of the record
  if (files.empty()) {
    identify::RunComparison found = identify::compare_runs(sources, console.progress_callback());
    are_files_straight = !command.intersample && take_files_as_straight(sources, found);
    if (are_files_straight) {
      found = identify::compare_runs(sources, console.progress_callback());
      found.notes.push_back(
          "The input of the files is taken as straight between their rows, as their errors fall by it "
          "(--intersample zoh: as held)");
    }
    console.end_progress();
    for (const std::string& note : found.notes) console.warning(note);
    document = described(found, sources).document;
    runs = converted(found, unit);
    shown = described(*runs, sources);
  } else if (!sources.empty()) {
    std::vector<const identify::Source*> each(models.size(), &sources.front());
    for (std::size_t i = 0; straight && i < each.size(); ++i) {
      if (takes_straight[i]) each[i] = &*straight;
    }
    std::vector<identify::ScoredModel> scored =
        without_own_record(identify::score_models(models, each, console.progress_callback()), models, sources.front());
    const auto drifting =
        std::find_if(scored.begin(), scored.end(), [](const auto& one) { return !one.drift.empty(); });
    if (drifting != scored.end()) console.warning(fmt::format("{}: {}", sources.front().name, drifting->drift));
    // Of the first that does not follow the record: one file, one cause.
    for (std::size_t i = 0; i < scored.size() && !exchange; ++i) {
      const auto other = identify::exchanged_fit(*each[i], {}, scored[i]);
      if (!other) continue;
      console.warning(
          fmt::format("{}: {}: {}", sources.front().name, files[i], identify::exchange_sentence(*other, scored[i])));
      exchange = fmt::format("eha validate {} {}{} {}", shell_word(files[i]), shell_word(records.front()),
                             importer::words_of_reading(command.import.command), sources.front().exchange);
    }
    console.end_progress();
    document = described(scored, models, files, sources.front()).document;
    for (std::size_t i = 0; i < scored.size(); ++i) scored[i] = converted(scored[i], unit, models[i].output_unit);
    shown = described(scored, shown_models, files, sources.front());
    // The page is read by who has not seen the terminal.
    for (const std::string& file : files) {
      const std::string own = own_record_text(file, sources.front());
      if (!own.empty()) shown.findings.sentences.push_back(capitalised(own) + ".");
    }
  } else {
    document = described(models, files).document;
    shown = described(shown_models, files);
  }
  if (command.output) {
    if (command.output->extension() == ".html") {
      if (!sources.empty()) shown.findings.rig = for_a_page(console.rig());
      for (const std::string& source : command.sources) shown.findings.sources.push_back(source_line(source));
      const report::Page page = report::comparison_page(shown.findings, shown.subjects);
      for (const std::string& sentence : page.missing) console.warning(sentence);
      os::write_file_atomically(*command.output, page.html);
    } else {
      draw_bode(shown.models, *command.output);
    }
    document["file"] = command.output->string();
    shown.text += fmt::format("written: {}\n", command.output->string());
  }
  console.print_json(document);
  console.print(shown.text);
  if (command.output) console.next_step("xdg-open " + shell_word(command.output->string()));
  if (exchange) {
    console.next_step(*exchange);
  } else if (shown.changed_source && !sources.empty()) {
    // Of models on a record the input between its rows is as for the first.
    const bool is_straight = are_files_straight || (straight && takes_straight.front());
    const auto intersample = is_straight ? std::optional(ident::Intersample::straight) : command.intersample;
    const std::size_t changed = *shown.changed_source;
    say_next_of_change(sources[changed], records[changed], shown.changes_valve, command, intersample, console);
  }
  return ExitCode::ok;
}

}  // namespace

void add_compare(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("compare", "Show what changed between runs, or which model suits a record");
  sub->footer(kCompareFooter);
  auto& command = options_of<CompareCommand>(*sub, line);
  takes_run_name(sub->add_option("sources", command.sources, "Run folders, records or model files (.json)"), line)
      ->required()
      ->expected(2, 1000)
      ->type_name("RUN|MODEL|FILE");
  add_intersample_option(*sub, command.intersample);
  sub->add_option("-o", command.output, "Report to write (.html), or a picture of the Bode plots (.svg, .png, .pdf)")
      ->type_name("FILE")
      ->check(ends_in(kEndings));
  add_import_options(*sub, line, command.import, ImportedColumns::record);
}

}  // namespace eha::cli
