// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/controller_argument.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <filesystem>
#include <span>
#include <system_error>
#include <utility>

#include "config/file_kind.hpp"
#include "core/error.hpp"
#include "core/os/written_at.hpp"
#include "core/shell_word.hpp"
#include "daemon/control/socket_path.hpp"
#include "daemon/eha/drive_options.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/service_text.hpp"
#include "daemon/eha/tuned_rig.hpp"
#include "daemon/record/resolved_path.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/sha256.hpp"
#include "daemon/tune/tune_inputs.hpp"
#include "hal/backends/backend.hpp"

namespace eha::cli {

namespace fs = std::filesystem;

using Json = nlohmann::ordered_json;

bool is_controller_file(const std::string& path) {
  std::error_code ignored;
  if (fs::path(path).extension() != ".toml" || !fs::is_regular_file(path, ignored)) return false;
  return config::kind_of(config::read_config_file(path), path) == config::FileKind::controller;
}

suggest::RigAccess access_of_rig(const config::RigConfig& rig, const std::string& rig_name, const std::string& run) {
  if (hal::moves_machine(rig.backend)) return access_of(DriveOptions{});
  if (record::is_run_folder(run)) {
    const Json entry = entry_of_run(run, control::default_socket());
    if (entry.is_object()) {
      suggest::RigAccess of_service = access_of(DriveOptions{});
      of_service.is_fast = entry.value("fast", false);
      return of_service;
    }
  }
  return simulated_access(rig_name.empty() ? std::nullopt : std::optional(rig_name));
}

suggest::RigAccess access_of_controller(const std::string& file, const config::ControllerConfig& controller) {
  const config::ControllerProvenance& from = controller.provenance;
  suggest::RigAccess access;
  try {
    access = access_of_rig(rig_of(from.rig_file), rig_name_of(from.rig_file), from.run);
  } catch (const Error&) {  // the rig file or the run is elsewhere by now
    access = usual_access();
  }
  access.controller = file;
  std::error_code ignored;
  if (fs::is_regular_file(from.model, ignored)) access.model = from.model;
  return access;
}

suggest::RigAccess for_a_page(suggest::RigAccess access) {
  for (std::string* name : {&access.rig_file, &access.output, &access.controller, &access.model}) {
    if (!name->empty()) *name = record::resolved_path(*name).string();
  }
  // The page may be read when the usual names are taken: that of its controller is.
  const std::string name = access.controller.empty() ? "new" : fs::path(access.controller).stem().string();
  if (!access.new_rig_file.empty()) access.new_rig_file = fmt::format("rig-{}.toml", name);
  access.new_controller = access.controller.empty() ? "" : fmt::format("{}-anew.toml", name);
  return access;
}

std::string rig_units_of_controller(const config::ControllerConfig& controller) {
  try {
    return rig_of(controller.provenance.rig_file).units;
  } catch (const Error&) {
    return {};
  }
}

std::string written_words(const fs::path& file) {
  const std::string written = os::written_at({file});
  return written.empty() ? std::string() : ", written " + written + " UTC";
}

tune::ControllerSubject controller_subject(config::ControllerConfig controller) {
  tune::ControllerSubject subject{.controller = std::move(controller)};
  const config::ControllerProvenance& from = subject.controller.provenance;
  std::error_code ignored;
  const auto again =
      fmt::format("make the controller anew: eha tune {} --rig {}", shell_word(from.model), shell_word(from.rig_file));
  if (!fs::is_regular_file(from.model, ignored) || !fs::exists(from.rig_file, ignored)) {
    subject.why_without_plots = fmt::format(
        "{} is not there any more; {}", fs::is_regular_file(from.model, ignored) ? from.rig_file : from.model, again);
    return subject;
  }
  const config::RigConfig rig = rig_of(from.rig_file);
  const bool is_same_rig = record::sha256_of(std::as_bytes(std::span(rig.text))) == from.rig_sha256;
  if (!is_same_rig || record::sha256_of_file(from.model) != from.model_sha256) {
    subject.why_without_plots =
        fmt::format("{} has changed since; {}", is_same_rig ? from.model : from.rig_file, again);
    return subject;
  }
  tune::TuneChoices choices;
  choices.purpose = subject.controller.purpose == "hold" ? ident::AxisPurpose::hold : ident::AxisPurpose::track;
  choices.sensitivity = tune::usual_sensitivity(choices.purpose);
  choices.tick_s = subject.controller.settings.tick_s;
  if (fs::is_regular_file(from.twin, ignored)) choices.twin = twin_of(from.twin);
  subject.inputs = tune::tune_inputs(read_model(from.model), rig, choices);
  ident::TrialPlan plan = ident::trial_plan(subject.controller.settings);
  plan.hold_s = 5.0;
  hal::SimOptions twin = subject.inputs->task.twin;
  twin.initial_displacement_in = 0.5 * (plan.lowest + plan.highest);
  static_cast<void>(
      tune::axis_trial(twin, ident::coefficients(subject.controller.settings), plan, &subject.trace.emplace()));
  return subject;
}

}  // namespace eha::cli
