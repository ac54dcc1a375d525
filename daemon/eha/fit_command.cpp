// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/eha/commands.hpp"
#include "daemon/eha/cross_validation.hpp"
#include "daemon/eha/frequency_table.hpp"
#include "daemon/eha/identification.hpp"
#include "daemon/eha/model_options.hpp"
#include "daemon/eha/new_folders.hpp"
#include "daemon/eha/source.hpp"
#include "daemon/eha/sweep.hpp"

namespace eha::cli {
namespace {

IdentificationTask task_for(const FitCommand& command, const Source& source) {
  IdentificationTask task{
      .record = source.record, .source_name = source.name, .interpolated_percent = interpolated_percent(source)};
  if (source.experiment) {
    task.options = source.experiment->fit;
    task.acceptance = source.experiment->acceptance;
  }
  task.structures = structures_for(
      command.models, source.experiment ? source.experiment->models : std::vector<ident::StructureOptions>{});
  task.options = with(task.options, command.record);
  task.options.procedure = command.procedure.value_or(task.options.procedure);
  task.options.seed = command.seed.value_or(task.options.seed);
  if (task.options.procedure == ident::Procedure::paper &&
      command.models.initial_state == ident::InitialState::estimated) {
    throw UsageError("--initial-state estimated: the paper's procedure estimates none; leave out one of the two");
  }
  return task;
}

/// Does `work`, and says a structure's fault as what it is: the command line's, when that asked for it.
template <class Work>
auto as_asked_for(const FitCommand& command, const Work& work) {
  try {
    return work();
  } catch (const ConfigError& error) {
    if (command.experiment_file) throw;
    throw UsageError(error.what());
  }
}

/// The files of the models, then that of the frequency response.
void write(Identification& identification, const FitCommand& command, const Source& source) {
  std::optional<std::filesystem::path> response;
  const auto write_response = [&](const std::filesystem::path& folder) {
    if (!identification.frequency_response) return;
    response = write_frequency_response(*identification.frequency_response, identification.models, folder);
  };
  if (command.output) {
    identification.written = write_models(identification.models, *command.output);
    write_response(*command.output);
  } else if (source.run_folder) {
    // First, as publishing the models lists every file of the folder in the manifest.
    write_response(*source.run_folder);
    identification.written = publish_models(*source.run_folder, identification.models, identification.paper);
  }
  if (response) identification.written.push_back(*response);
}

std::string next_step(const FitCommand& command, const Identification& identification) {
  // The models' files come first.
  const std::size_t files = std::min(identification.models.size(), identification.written.size());
  for (std::size_t i = 0; i < files; ++i) {
    const auto& verdict = identification.models[i].result.model.verdict;
    if (verdict && verdict->accepted) {
      return fmt::format("eha simulate {} INPUT.csv -o OUTPUT.csv", identification.written[i].string());
    }
  }
  // Before the words as given: behind a `--` it would be one of them.
  std::string again = command.as_given;
  return again.insert(again.find("fit") + 3, " -o models");
}

}  // namespace

ExitCode execute(const FitCommand& command, Console& console) {
  const Source source = load_source(command.source, command.experiment_file);
  for (const std::string& sentence : reservations(source)) console.warning(sentence);
  const IdentificationTask task = task_for(command, source);
  if (command.sweep) {
    const auto folder = command.output      ? command.output
                        : source.run_folder ? std::optional(*source.run_folder / record::kModelsFolder)
                                            : std::nullopt;
    return as_asked_for(command, [&] { return sweep_commensurate_order(command, task, folder, console); });
  }
  std::optional<NewFolders> folder;
  if (command.output) folder.emplace(*command.output);
  Identification identification;
  identification.models = as_asked_for(command, [&] { return identify(task, console); });
  if (source.run_folder) identification.paper = identify_as_in_the_paper(task, console);
  if (command.cross_validate) {
    identification.cross_validation = cross_validate(task, source.repetition_samples, console);
  }
  identification.frequency_response = frequency_response_of(source, task.options, console);
  write(identification, command, source);
  show(identification, {{"schema", "eha-fit/1"}, {"source", command.source}}, console);
  if (identification.written.empty()) console.print("Nothing written; -o DIR writes one file per model.");
  const ExitCode code = exit_code(identification.models);
  if (code == ExitCode::ok) console.next_step(next_step(command, identification));
  return code;
}

}  // namespace eha::cli
