// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/tune_next.hpp"

#include <fmt/format.h>

#include <variant>

#include "config/prepared_experiment.hpp"
#include "config/track_text.hpp"
#include "core/error.hpp"
#include "core/shell_word.hpp"
#include "daemon/eha/controller_argument.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/eha/new_folders.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/tune_command.hpp"
#include "daemon/eha/tune_origin.hpp"
#include "daemon/rig/calibration.hpp"
#include "daemon/tune/promised_plant.hpp"
#include "hal/backends/backend.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;

/// The commands that tune a model on a twin of its own record.
struct TwinCommands {
  std::string replay;
  std::string tune;
};

TwinCommands twin_commands(const TuneCommand& command, const ident::Model& model) {
  const std::string record = record_of(model);
  const std::string rig = command.rig_file ? " --rig " + shell_word(*command.rig_file) : "";
  const std::string twin = shell_word(free_name("twin.toml"));
  return {fmt::format("eha replay {}{} --calibrate valve_rated_flow_L_per_min valve_null_offset_V valve_dead_band_V "
                      "--twin {}",
                      record.empty() ? "RECORD" : shell_word(record), rig, twin),
          fmt::format("eha tune {}{} --twin {}", shell_word(command.model_file), rig, twin)};
}

std::string twin_of_record(const TuneCommand& command, const ident::Model& model) {
  const TwinCommands commands = twin_commands(command, model);
  return fmt::format("`{}` fits a simulated rig to that record; then `{}`", commands.replay, commands.tune);
}

bool is_played_on(const config::RigConfig& rig, const config::ControllerConfig& controller) {
  return trial_on(rig, controller).has_value();
}

}  // namespace

std::optional<config::Track> trial_on(const config::RigConfig& rig, const config::ControllerConfig& controller) {
  try {
    const std::string text = rig_text_with_tick(rig, controller.settings.tick_s);
    const config::PreparedExperiment experiment = config::parse_prepared_experiment(
        config::track_experiment(controller.name, config::controller_text(controller), {}), "track",
        config::parse_rig(text, rig.file_name));
    return experiment.config.tracking()->track;
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::vector<std::string> next_steps(const TuneCommand& command, const ident::Model& model, const config::RigConfig& rig,
                                    const config::ControllerConfig& controller, const suggest::RigAccess& access,
                                    const std::optional<tune::ExpectedTrip>& trip,
                                    const std::optional<std::string>& valve_first, bool is_of_before,
                                    const fs::path& page) {
  const std::string show = "xdg-open " + shell_word(page.string());
  if (hal::moves_machine(rig.backend)) return {show};
  const std::string on_rig = suggest::track(access, command.output.string());
  const bool is_to_repair = leak_of(command, model) || (trip && (trip->is_of_leak || command.sheet_run));
  if (is_to_repair) return {show};
  if (is_of_before) return {suggest::run(access, {"EXPERIMENT.toml"}), show};
  if (trip) return {suggest::characterise(access), show};
  const bool is_own = why_not_of(command, model, rig).empty();
  if (valve_first && is_own && !command.twin_file) return {*valve_first, show};
  if (!access.is_local) return {on_rig};  // the service checks it with its own rig file
  if (is_own && is_played_on(rig, controller)) return {on_rig};
  if (command.twin_file && is_played_on(config::load_rig(*command.twin_file), controller)) {
    return {suggest::track(simulated_access(command.twin_file), command.output.string())};
  }
  if (command.twin_file) return {is_played_on(rig, controller) ? on_rig : show};
  // A trial here would try another plant than that of a record that can be replayed.
  if (record_of(model).empty() && is_played_on(rig, controller)) return {on_rig};
  const TwinCommands twin = twin_commands(command, model);
  return {twin.replay, twin.tune + " -o " + shell_word(free_name(command.output.string()))};
}

std::vector<std::string> plant_sentences(const TuneCommand& command, const ident::Model& model,
                                         const config::RigConfig& rig, const tune::TuneInputs& inputs,
                                         const fs::path& rig_file) {
  const std::string unknown = why_not_of(command, model, rig);
  const std::string other = tune::why_another_plant(inputs);
  const bool is_own_twin = !command.twin_file && std::holds_alternative<hal::SimOptions>(rig.backend);
  std::vector<std::string> sentences;
  if (is_own_twin && !unknown.empty() && !other.empty()) {
    const std::string what_to_do = tune::returns_in_s(inputs)
                                       ? "this program makes controllers of cylinders alone; `eha export " +
                                             shell_word(command.model_file) +
                                             " --format tf` writes the model for the design in another one"
                                       : twin_of_record(command, model);
    throw DataError(
        fmt::format("the model is not of the simulated rig {} ({}): {}. A promise would be of another plant; {}",
                    rig_file.string(), unknown, other, what_to_do));
  }
  if (command.twin_file) {
    sentences.push_back(
        fmt::format("Promised for: the simulated rig {} that --twin names, with limits and sensor of {}.",
                    *command.twin_file, rig_file.string()));
  } else if (!is_own_twin) {
    sentences.push_back(fmt::format(
        "Promised for: a rig estimated from model and valve, with limits and sensor of {}{}.", rig_file.string(),
        unknown.empty() ? "" : fmt::format("; nothing shows that the model is of that rig: {}", unknown)));
  } else if (unknown.empty()) {
    sentences.push_back(
        fmt::format("Promised for: the simulated rig of {}, which made the model's record. The trials are on the same "
                    "simulation, so that the promise knows its oil, load and friction; that of a machine is wider.",
                    rig_file.string()));
  } else {
    sentences.push_back(
        fmt::format("Promised for: the simulated rig {}, and not for the plant of {}: {}, so nothing shows that the "
                    "two are one. For "
                    "the plant of the record, {}.",
                    rig_file.string(), command.model_file, unknown, twin_of_record(command, model)));
  }
  if (!other.empty()) sentences.push_back(fmt::format("Check before use: {}.", other));
  if (model.verdict && needs_longer_record(*model.verdict)) {
    sentences.push_back(
        fmt::format("The record is too short to judge the model: {}, or a longer record has judged the model.",
                    ident::kControllerIsAGuess));
  }
  return sentences;
}

}  // namespace eha::cli
