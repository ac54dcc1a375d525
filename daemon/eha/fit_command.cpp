// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/eha/commands.hpp"
#include "daemon/eha/identification_report.hpp"
#include "daemon/eha/import_options.hpp"
#include "daemon/eha/model_options.hpp"
#include "daemon/eha/new_folders.hpp"
#include "daemon/eha/sweep_command.hpp"
#include "daemon/eha/valve_sheet.hpp"
#include "daemon/identify/identification.hpp"
#include "daemon/identify/publish.hpp"
#include "daemon/identify/source.hpp"
#include "daemon/importer/table.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;
using identify::Comparisons;
using identify::Identification;
using identify::IdentificationTask;
using identify::Source;

IdentificationTask task_for(const FitCommand& command, const Source& source) {
  IdentificationTask task = identify::task_of(source);
  task.structures = structures_for(command.models, task.structures);
  task.ladder = ladder_for(command.models);
  task.options = with(task.options, command.record);
  task.options.procedure = command.procedure.value_or(task.options.procedure);
  task.options.seed = command.seed.value_or(task.options.seed);
  if (task.options.procedure == ident::Procedure::paper &&
      command.models.initial_state == ident::InitialState::estimated) {
    throw UsageError("--initial-state estimated: the paper's procedure estimates none; leave out one of the two");
  }
  return task;
}

/// Models named on the command line are meant; those of an experiment may be replaced by others.
bool names_models(const ModelOptions& options) { return !options.families.empty() || !options.structure_files.empty(); }

Comparisons comparisons_for(const FitCommand& command, const Source& source) {
  const bool of_experiment = !command.procedure && source.experiment && source.experiment->compares_with_paper;
  return {.paper = command.compares_with_paper || of_experiment ? Comparisons::Paper::include
                                                                : Comparisons::Paper::leave_out,
          .cross_validation =
              command.cross_validate ? Comparisons::CrossValidation::include : Comparisons::CrossValidation::leave_out,
          .ladder = names_models(command.models) ? Comparisons::Ladder::leave_out : Comparisons::Ladder::include};
}

/// Does `work`. A wrong structure is a usage error unless an experiment file was named.
template <class Work>
auto as_asked_for(const FitCommand& command, const Work& work) {
  try {
    return work();
  } catch (const ConfigError& error) {
    if (command.experiment_file) throw;
    throw UsageError(error.what());
  }
}

std::vector<fs::path> write(const Identification& identification, const FitCommand& command, const Source& source) {
  if (command.output) return identify::write_models(identification, *command.output);
  if (source.run_folder) return identify::publish(identification, *source.run_folder);
  return {};
}

std::string next_step(const FitCommand& command, const Identification& identification,
                      const std::vector<fs::path>& written) {
  // The models' files come first. The recommended model, else the first accepted one.
  const std::size_t files = std::min(identification.models.size(), written.size());
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < files; ++i) {
    if (!is_accepted(identification.models[i])) continue;
    const bool is_recommended = identification.models[i].result.model.name == identification.recommendation.model;
    if (!best || is_recommended) best = i;
  }
  if (best) return fmt::format("eha simulate {} INPUT.csv -o OUTPUT.csv", written[*best].string());
  return importer::command_with(command.import, command.source, "-o models");
}

}  // namespace

ExitCode execute(const FitCommand& command, Console& console) {
  const Source source =
      identify::load_source(command.source, command.experiment_file, command.import, console.progress_callback());
  console.end_progress();
  print_import(source.guess, source.repairs, console);
  const bool names_models = !command.models.families.empty() || !command.models.structure_files.empty();
  if (source.run_folder && source.experiment && source.experiment->characterises && !names_models) {
    // What such a run is for.
    return show_valve_sheet(*source.run_folder, SheetFiles::write, console);
  }
  const IdentificationTask task = task_for(command, source);
  print_warnings(source, task.options.decimation, console);
  if (command.sweep) {
    const auto folder = command.output      ? command.output
                        : source.run_folder ? std::optional(*source.run_folder / record::kModelsFolder)
                                            : std::nullopt;
    return as_asked_for(command, [&] { return sweep_commensurate_order(command, task, folder, console); });
  }
  std::optional<NewFolders> folder;
  if (command.output) folder.emplace(*command.output);
  const Identification identification = as_asked_for(command, [&] {
    return identify::identify(source, task, comparisons_for(command, source), console.progress_callback());
  });
  console.end_progress();
  std::vector<fs::path> written = write(identification, command, source);
  const DisplayUnit unit = console.unit(source.units);
  if (source.run_folder && !command.output) write_report(*source.run_folder, unit, written, console);
  print_identification(identification, written, {{"schema", "eha-fit/1"}, {"source", command.source}}, unit, console);
  if (written.empty()) console.print("Nothing written; -o DIR writes one file per model.");
  const ExitCode code = identify::exit_code(identification.models);
  if (code == ExitCode::ok) console.next_step(next_step(command, identification, written));
  if (const auto next = identify::next_experiment_file(written)) {
    console.next_step(fmt::format("eha run {}", next->string()));
  }
  return code;
}

}  // namespace eha::cli
