// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/next_command.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "config/rig_config.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/acquisition/run_report.hpp"
#include "daemon/control/socket_path.hpp"
#include "daemon/eha/drive_options.hpp"
#include "daemon/eha/following_trip.hpp"
#include "daemon/eha/following_warning.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/run_command.hpp"
#include "daemon/eha/short_report.hpp"
#include "daemon/identify/identification.hpp"
#include "daemon/identify/source.hpp"
#include "daemon/importer/import.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/own_file.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_summary.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "daemon/report/report.hpp"
#include "hal/backends/backend.hpp"
#include "ident/estimation/fit_rows.hpp"
#include "ident/model/model_file.hpp"

namespace eha::cli {

namespace fs = std::filesystem;

namespace {

/// A path below the present folder without that folder.
std::string short_path(const fs::path& file) {
  std::error_code ignored;
  const fs::path here = fs::proximate(file, ignored);
  return here.empty() || here.begin()->string() == ".." ? file.string() : here.string();
}

}  // namespace

std::string through(const fs::path& socket, std::string command) {
  return suggest::through(socket == control::default_socket() ? "" : socket.string(), std::move(command));
}

std::string put_in_force(const fs::path& made, const fs::path& of_service, const fs::path& socket, InForce then) {
  const bool is_writable = access(of_service.c_str(), W_OK) == 0;
  return fmt::format("{} && {}cp {} {} && {} && {}", through(socket, "eha disarm"), is_writable ? "" : "sudo ",
                     shell_word(made.string()), shell_word(of_service.string()), through(socket, "eha reload"),
                     through(socket, then == InForce::arm ? "eha arm" : "eha read"));
}

namespace {

/// Names for new files.
suggest::RigAccess with_free_names(suggest::RigAccess rig) {
  constexpr const char* kUsualController = "controller.toml";
  rig.new_rig_file = free_name(rig.new_rig_file);
  rig.bare_rig_file = free_name(rig.bare_rig_file);
  // `eha tune` writes the usual file without -o, and overwrites none.
  if (const std::string free = free_name(kUsualController); free != kUsualController) rig.new_controller = free;
  return rig;
}

}  // namespace

suggest::RigAccess access_of(const DriveOptions& drive) {
  suggest::RigAccess rig{.is_local = drive.local, .is_fast = drive.fast};
  if (drive.local) {
    rig.rig_file = drive.rig_file.value_or("");
    if (drive.output != DriveOptions{}.output) rig.output = drive.output.string();
    rig.allows_non_realtime = drive.allow_non_realtime;
  } else if (drive.socket != control::default_socket()) {
    rig.socket = drive.socket.string();
  }
  return with_free_names(std::move(rig));
}

suggest::RigAccess access_of(const RunCommand& run) {
  suggest::RigAccess rig = access_of(static_cast<const DriveOptions&>(run));
  rig.accepts_travel_risk = run.accept_travel_risk;
  rig.controller = run.controller_file;
  rig.model = run.controller_model;
  return rig;
}

suggest::RigAccess simulated_access(const std::optional<std::string>& rig_file) {
  DriveOptions drive;
  drive.local = true;
  drive.fast = true;
  drive.rig_file = rig_file;
  return access_of(drive);
}

suggest::RigAccess access_of_rig(const config::RigConfig& rig, const std::optional<std::string>& named) {
  return hal::moves_machine(rig.backend) ? access_of(DriveOptions{}) : simulated_access(named);
}

suggest::RigAccess usual_access() {
  std::error_code ignored;
  const bool has_service = fs::exists(control::default_socket(), ignored);
  return has_service || default_rig_moves_machine() ? access_of(DriveOptions{}) : simulated_access({});
}

suggest::RigAccess access_of_file() {
  suggest::RigAccess rig = access_of(DriveOptions{});
  rig.new_rig_file.clear();
  return rig;
}

std::string an_experiment() {
  std::vector<fs::path> folders{fs::path(EHA_DATA_DIR) / "experiments", fs::path("config") / "experiments"};
  if (const auto rig = default_rig_file()) folders.push_back(rig->parent_path().parent_path() / "experiments");
  for (const fs::path& folder : folders) {
    const fs::path file = folder / "paper.toml";
    std::error_code ignored;
    if (fs::is_regular_file(file, ignored)) return short_path(file);
  }
  return "EXPERIMENT.toml";
}

std::string rig_name(const fs::path& file) {
  const std::optional<fs::path> usual = default_rig_file();
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored) || (usual && fs::equivalent(file, *usual, ignored))) return {};
  return short_path(file);
}

suggest::RigAccess access_of_run(const fs::path& folder, bool asked_service) {
  const nlohmann::ordered_json manifest = record::read_manifest(folder).other;
  suggest::RigAccess rig = suggest::access_of_run(manifest);
  rig.new_rig_file = suggest::RigAccess{}.new_rig_file;
  rig.new_controller.clear();
  const nlohmann::ordered_json::json_pointer backend("/device/backend");
  if (!manifest.contains("played_by") && !rig.is_local) {
    rig.is_local = !asked_service && manifest.contains(backend) && manifest.at(backend) == hal::SimOptions::kName;
  }
  std::error_code ignored;
  const nlohmann::ordered_json::json_pointer file("/rig/file");
  rig.rig_file.clear();
  if (rig.is_local && manifest.contains(file) && manifest.at(file).is_string()) {
    rig.rig_file = rig_name(manifest.at(file).get<std::string>());
  }
  for (std::string* name : {&rig.controller, &rig.model}) {
    if (!name->empty()) *name = fs::exists(*name, ignored) ? short_path(*name) : std::string();
  }
  const std::string output = short_path(fs::absolute(folder, ignored).lexically_normal().parent_path());
  if (rig.is_local && output != DriveOptions{}.output) rig.output = output;
  return with_free_names(std::move(rig));
}

std::optional<std::string> input_words_of_record(const std::string& record, const std::string& unit) {
  if (record.empty()) return std::nullopt;
  std::error_code ignored;
  std::string file = record;
  if (fs::is_directory(record, ignored)) {
    file.clear();
    for (const fs::directory_entry& entry : fs::directory_iterator(record, ignored)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with("data_") && name.ends_with("ms.csv")) file = entry.path().string();
    }
  }
  if (!fs::is_regular_file(file, ignored)) return std::nullopt;
  try {
    static_cast<void>(importer::import_input(file, {}, unit));
    // Between the thinned rows of a run its input moved on.
    return shell_word(file) + (file == record ? "" : " --intersample foh");
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::string report_of_run(const std::filesystem::path& folder, const std::string& otherwise) {
  const std::filesystem::path page = folder / report::kReportFile;
  std::error_code ignored;
  return std::filesystem::exists(page, ignored) ? "xdg-open " + shell_word(page.string()) : otherwise;
}

std::string_view fault_name(std::string_view description) { return description.substr(0, description.find(' ')); }

std::string next_after_trip(const Trip& trip, const config::RigConfig* of_run, const suggest::RigAccess& rig) {
  const bool is_simulated = of_run != nullptr && !hal::moves_machine(of_run->backend);
  // At a limit of the travel the volts or the place were mostly too great, whatever [following] says.
  const bool is_at_limit = trip.fault == acquisition::to_text(acquisition::Fault::travel_limit);
  if (!is_simulated || is_at_limit || !is_first_of_following(trip)) return suggest::read(rig);
  return of_run->limits.following ? suggest::without_following(rig) : suggest::characterise(rig);
}

namespace {

constexpr double kMostUnmeasured = 20.0;  // of the rows [%] of a record that a fit is advised for

double unmeasured_percent(const fs::path& folder) {
  try {
    return ident::unmeasured_of(record::read_run(folder).record).percent();
  } catch (const Error&) {
    return 0.0;
  }
}

}  // namespace

void require_writable_run(const fs::path& folder, const std::string& command, const std::string& output) {
  std::error_code unknown;
  if (!fs::is_directory(folder, unknown) || ::access(folder.c_str(), W_OK) == 0) return;
  throw PermissionError(
      fmt::format("{}: you may not write there, as the runs of the service are its own; to write "
                  "beside it: `{} -o {}`",
                  folder.string(), command, shell_word(free_name(output))));
}

std::optional<std::string> fit_of_run(const fs::path& folder) {
  try {
    const identify::Source source = identify::load_source(folder.string(), {}, {}, {});
    if (source.unmeasured.percent() > kMostUnmeasured) return std::nullopt;
    const ident::FitOptions options = identify::task_of(source).options;
    ident::check_record(source.record, options);
    static_cast<void>(ident::fit_rows(source.record, options));
    const std::string fit = "eha fit " + shell_word(folder.string());
    // The runs of the service are its own.
    if (::access(folder.c_str(), W_OK) == 0) return fit;
    return fit + " -o " + shell_word(free_name("fit-" + folder.filename().string()));
  } catch (const Error&) {
    return std::nullopt;
  }
}

bool has_rows(const fs::path& folder) {
  try {
    return record::read_run(folder).record.output.size() > 0;
  } catch (const Error&) {
    return false;
  }
}

std::string partial_record_text(const fs::path& folder) {
  const std::string place = fmt::format("the partial record is in {}", folder.string());
  if (const auto fit = fit_of_run(folder)) return fmt::format("{}; `{}` fits it", place, *fit);
  if (!has_rows(folder)) {
    return fmt::format("the run ended before its first row; {} has its log alone", folder.string());
  }
  const double unmeasured = unmeasured_percent(folder);
  const std::string why = unmeasured > kMostUnmeasured
                              ? fmt::format("{:.0f} % of its rows were not measured, it is not worth a fit", unmeasured)
                              : std::string("it is too short to fit");
  return fmt::format("{}; {}, `eha plot {}` shows it", place, why, shell_word(folder.string()));
}

std::string kept_record_text(const fs::path& folder) {
  const std::string place = fmt::format("the partial record is in {}", folder.string());
  bool is_cut_sheet = false;
  try {
    const record::Manifest manifest = record::read_manifest(folder);
    is_cut_sheet = manifest.outcome == acquisition::Outcome::deadline &&
                   record::purpose_of(manifest) == record::Purpose::valve_sheet;
  } catch (const Error&) {
    return place;  // a folder that the caller may not read
  }
  if (!has_rows(folder)) return partial_record_text(folder);
  const std::string name = shell_word(folder.string());
  return fmt::format("{}; `eha plot {}` shows it{}", place, name,
                     is_cut_sheet ? fmt::format(", `eha characterise {}` what it tells of the valve", name) : "");
}

std::optional<fs::path> recommended_model(const fs::path& folder) {
  const nlohmann::ordered_json other = record::read_manifest(folder).other;
  const nlohmann::ordered_json::json_pointer place("/identification/recommendation/model");
  if (!other.contains(place) || !other.at(place).is_string()) return std::nullopt;  // null: none is recommended
  const fs::path file = record::listed_file(
      folder, (fs::path(record::kModelsFolder) / (other.at(place).get<std::string>() + ".json")).string());
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return std::nullopt;
  return file;
}

std::string why_no_model(const fs::path& folder) {
  const record::Manifest manifest = record::read_manifest(folder);
  const std::string name = folder.string();
  const std::string show = "`eha runs show " + shell_word(name) + "`";
  std::error_code ignored;
  const fs::path models = folder / record::kModelsFolder;
  const bool has_models = std::any_of(fs::directory_iterator(models, ignored), fs::directory_iterator(),
                                      [](const fs::directory_entry& file) { return file.is_regular_file(); });
  if (has_models) {
    return fmt::format("{}: this run recommends none of its models, {} says why; name one of {}", name, show,
                       models.string());
  }
  if (manifest.outcome && acquisition::is_whole(*manifest.outcome)) {
    return fmt::format("{}: this run recommends no model, {} shows what it has; name a run of an experiment", name,
                       show);
  }
  const std::string fault = record::summary_of(name, manifest).fault;
  return fmt::format(
      "{}: the run did not end as planned ({}) and has no model, {} says how; {}", name,
      fault.empty() ? record::outcome_text(manifest) : fault, show,
      record::purpose_of(manifest) == record::Purpose::models ? partial_record_text(folder) : kept_record_text(folder));
}

ident::NextStep first_of_run(const fs::path& folder) {
  try {
    const Answer answer = answer_of_run(folder, record::read_manifest(folder));
    std::vector<const ident::Model*> models;
    for (const ident::Model& model : answer.models) models.push_back(&model);
    return ident::next_step(models, answer.recommendation.model);
  } catch (const Error&) {  // a folder that the caller may not read
    return {};
  }
}

std::optional<std::string> cut_of_run(const fs::path& folder) {
  const std::string cut = first_of_run(folder).cut_options;
  if (cut.empty()) return std::nullopt;
  return fmt::format("eha fit {} {}", shell_word(folder.string()), cut);
}

namespace {

ident::Model model_in(const fs::path& file) { return ident::model_from_text(os::read_file(file), file.string()); }

/// The newest valve sheet of the same rig beside a run; empty without one, or if the valve has changed since.
std::string sheet_beside(const fs::path& folder, const ident::Model& model) {
  const auto run = record::newest_sheet_run(folder);
  if (!run) return {};
  const auto sheet = valve_of_sheet(*run);
  if (model.input_map && sheet && !is_of_one_valve(model, *sheet)) return {};
  return run->string();
}

}  // namespace

std::optional<std::string> tune_of_run(const fs::path& folder, const suggest::RigAccess& rig) {
  const auto model = recommended_model(folder);
  if (!model) return std::nullopt;
  const ident::Model read = model_in(*model);
  if (read.grey_box) return std::nullopt;  // no controller is made of one
  return suggest::tune(rig, folder.string(), sheet_beside(folder, read));
}

std::string tune_of_model(const fs::path& model, const fs::path& run, const suggest::RigAccess& rig) {
  return suggest::tune(rig, model.string(), sheet_beside(run, model_in(model)));
}

}  // namespace eha::cli
