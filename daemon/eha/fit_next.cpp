// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/fit_next.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <system_error>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "ident/model/model_file.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/explanation.hpp"
#include "ident/validation/first_step.hpp"
#include "ident/validation/slow_pair.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::cli {

namespace fs = std::filesystem;
using identify::Identification;
using identify::Source;

namespace {

/// A folder that is not there yet: "models", or "models-bench" where that has models of another record.
std::string folder_to_offer(const FitCommand& command, const Source& source) {
  if (!model_of_other_record("models", source)) return free_name("models");
  return free_name("models-" + fs::path(command.source).stem().string());
}

/// The fit of a part of the record. @param options  "--to 27.68"
std::string fit_of_part(const FitCommand& command, const Source& source, const std::string& options) {
  const std::string folder =
      command.output || source.run_folder ? std::string() : " -o " + shell_word(folder_to_offer(command, source));
  return importer::command_with(command.import, command.source, options + folder);
}

/// The fit of another structure in the place of the named ones. @param options  "--model friction"
std::string fit_of_structure(const FitCommand& command, const Source& source, const std::string& options) {
  importer::Options without = command.import;
  without.command = command_of_ladder(command);
  std::string family = options.substr(options.find(' ') + 1);
  family = family.substr(0, family.find(' '));
  const std::string folder = command.output      ? std::string()
                             : source.run_folder ? " -o " + shell_word(free_name("models-" + family))
                                                 : " -o " + shell_word(folder_to_offer(command, source));
  return importer::command_with(without, command.source, options + folder);
}

}  // namespace

std::optional<OtherModel> model_of_other_record(const fs::path& folder, const Source& source) {
  std::error_code ignored;
  for (const auto& file : fs::directory_iterator(folder, ignored)) {
    if (file.path().extension() != ".json" || !file.is_regular_file(ignored)) continue;
    try {
      const ident::Model model = ident::model_from_text(os::read_file(file.path()), file.path().string());
      const std::string record = record_of(model);
      if (!record.empty() && record != source.name) return OtherModel{file.path().filename().string(), record};
    } catch (const Error&) {
      continue;  // not a model file
    }
  }
  return std::nullopt;
}

std::optional<std::string> cut_command(const FitCommand& command, const Source& source,
                                       const Identification& identification) {
  if (command.import.from_s || command.import.to_s) return std::nullopt;
  const std::string cut = identify::next_step_of(identification).cut_options;
  if (cut.empty()) return std::nullopt;
  return fit_of_part(command, source, cut);
}

std::string mending_fit(const FitCommand& command, const Source& source, const Identification& identification) {
  constexpr std::string_view kLate = "--input-late ";
  std::string options = identification.mended_input;
  // Of a column that was shifted already it is the rest.
  if (options.starts_with(kLate)) {
    options = fmt::format("{}{}", kLate, command.import.input_late + std::stoul(options.substr(kLate.size())));
  }
  if (!options.empty() && identify::next_step_of(identification).first == ident::FirstStep::take_rows_as_even) {
    FitCommand even = command;
    even.import.command = importer::command_without_flag(even.import, "--resample");
    return fit_of_part(even, source, options);
  }
  return options.empty() ? picture_of_record(command) : fit_of_part(command, source, options);
}

/// A folder beside the one that a fit has written into; in the present one for "." and "..", which have no name to
/// number.
std::string folder_beside(const fs::path& written) {
  const fs::path last = written.has_filename() ? written.filename() : written.parent_path().filename();
  return last == "." || last == ".." ? free_name("models") : next_free_name(written.string());
}

FitCommand into_new_folder(FitCommand command) {
  if (!command.output || command.import.command.empty()) return command;
  command.import.command = importer::command_without(command.import, {"-o"});
  command.import.command =
      importer::command_with(command.import, command.source, "-o " + shell_word(folder_beside(*command.output)));
  return command;
}

std::string command_of_ladder(const FitCommand& command) {
  const std::string ladder =
      importer::command_without(command.import, {"--model", "--structure", "--poles", "--zeros", "--delay",
                                                 "--input-map", "--fix", "--free", "--start", "--bound"});
  return ladder.empty() ? "eha fit " + shell_word(command.source) : ladder;
}

std::string next_of_fit(const FitCommand& command, const Source& source, const Identification& identification,
                        const std::vector<fs::path>& written) {
  // The models' files come first. Picks the recommended model, else the first accepted one.
  const std::size_t files = std::min(identification.models.size(), written.size());
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < files; ++i) {
    if (!is_accepted(identification.models[i])) continue;
    const bool is_recommended = identification.models[i].result.model.name == identification.recommendation.model;
    if (!best || is_recommended) best = i;
  }
  if (identification.recommendation.model.empty() && !source.run_folder && !names_models(command.models)) {
    if (command.output) return "eha report " + shell_word(command.output->string()) + "/*.json";
  }
  // The part before a trip or a stop is short: recommends its report before a controller.
  const bool is_whole = acquisition::is_whole(source.outcome);
  const bool asks_for_more = identify::next_step_of(identification).first != ident::FirstStep::none ||
                             (source.run_folder && record::leak_beside(*source.run_folder));
  const bool is_grey = best && identification.models[*best].result.model.grey_box.has_value();
  if (best && source.run_folder && (!is_whole || asks_for_more || is_grey)) {
    return report_of_run(*source.run_folder, "eha runs show " + shell_word(source.run_folder->string()));
  }
  if (best && source.run_folder) {
    const auto tune =
        command.output ? std::nullopt : tune_of_run(*source.run_folder, access_of_run(*source.run_folder));
    return tune ? *tune : tune_of_model(written[*best], *source.run_folder, access_of_run(*source.run_folder));
  }
  if (best) return "eha report " + shell_word(command.output->string()) + "/*.json";
  return importer::command_with(command.import, command.source, "-o " + shell_word(folder_to_offer(command, source)));
}

std::string picture_of_record(const FitCommand& command) {
  const std::string picture = free_name(fs::path(command.source).filename().replace_extension(".svg").string());
  return fmt::format("eha plot {} -o {}", shell_word(command.source), shell_word(picture));
}

std::optional<std::string> step_by_cause(const FitCommand& command, const Source& source,
                                         const Identification& identification, const std::vector<fs::path>& written) {
  const ident::Recommendation& recommendation = identification.recommendation;
  const bool has_model = !recommendation.model.empty();
  const std::string& named = has_model ? recommendation.model : recommendation.runner_up;
  for (const identify::IdentifiedModel& one : identification.models) {
    const ident::Model& model = one.result.model;
    if (!model.verdict) continue;
    const bool is_reason =
        !model.verdict->reasons.empty() && recommendation.reason + "." == model.verdict->reasons.front();
    if (model.name != named && !is_reason && identification.models.size() > 1) continue;
    const auto explained = ident::explanation_of(model, *model.verdict);
    if (explained && explained->kind == ident::ExplanationKind::structure) {
      return fit_of_structure(command, source, explained->options);
    }
    if (explained && !explained->options.empty()) return fit_of_part(command, source, explained->options);
    if (explained && !has_model) return picture_of_record(command);
    const ident::GreyBoxKind* kind = ident::grey_box_to_advise(model, *model.verdict);
    if (kind != nullptr && (!has_model || written.empty())) {
      return fit_of_structure(command, source, fmt::format("--model {}", kind->name));
    }
    if (ident::takes_in_a_drift(model)) return picture_of_record(command);
    if (!has_model && !is_accepted(one) && ident::wanders(model, *model.verdict) &&
        ident::error_cause(model, *model.verdict) == ident::ErrorCause::drift) {
      return picture_of_record(command);
    }
  }
  return std::nullopt;
}

}  // namespace eha::cli
