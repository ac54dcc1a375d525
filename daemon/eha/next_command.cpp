// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/next_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/control/socket_path.hpp"
#include "daemon/eha/following_warning.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/run_command.hpp"
#include "daemon/eha/short_report.hpp"
#include "daemon/identify/identification.hpp"
#include "daemon/identify/source.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/report/report.hpp"
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

std::string through(const std::filesystem::path& socket, std::string command) {
  if (socket != control::default_socket()) command += " --socket " + shell_word(socket.string());
  return command;
}

std::string put_in_force(const fs::path& made, const fs::path& of_service, const fs::path& socket) {
  return fmt::format("{} && sudo cp {} {} && {}", through(socket, "eha disarm"), shell_word(made.string()),
                     shell_word(of_service.string()), through(socket, "eha reload"));
}

std::string again(const RunCommand& run, const std::string& experiment) { return again(run, std::vector{experiment}); }

std::string again(const RunCommand& run, const std::vector<std::string>& experiments) {
  std::string command = "eha run";
  for (const std::string& experiment : experiments) command += " " + shell_word(experiment);
  if (run.local) command += " --local";
  if (run.fast) command += " --fast";
  if (run.accept_travel_risk) command += " --accept-travel-risk";
  if (!run.local) return through(run.socket, command);
  if (run.rig_file) command += " --rig " + shell_word(*run.rig_file);
  if (run.output != RunCommand{}.output) command += " --output " + shell_word(run.output.string());
  if (run.allow_non_realtime) command += " --allow-non-realtime";
  return command;
}

std::string simulated_run(const std::string& experiment, const std::optional<std::string>& rig_file) {
  RunCommand run;
  run.local = true;
  run.fast = true;
  run.rig_file = rig_file;
  return again(run, experiment);
}

std::string free_name(const std::string& name) {
  const fs::path path(name);
  fs::path free = path;
  std::error_code ignored;
  for (int number = 2; fs::exists(fs::symlink_status(free, ignored)); ++number) {
    free = path;
    free.replace_filename(fmt::format("{}-{}{}", path.stem().string(), number, path.extension().string()));
  }
  return free.string();
}

std::string characterise_anew(const std::string& run) {
  return fmt::format("eha characterise {}-o {}", run.empty() ? "" : shell_word(run) + " ", free_name("rig-new.toml"));
}

std::string report_of_run(const std::filesystem::path& folder, const std::string& otherwise) {
  const std::filesystem::path page = folder / report::kReportFile;
  std::error_code ignored;
  return std::filesystem::exists(page, ignored) ? "xdg-open " + shell_word(page.string()) : otherwise;
}

std::string next_after_trip(std::string_view fault, bool moves_machine) {
  constexpr std::array<std::string_view, 4> kOfFollowing{"no_motion", "not_in_place", "loop_speed", "wrong_speed"};
  const bool is_of_following = std::find(kOfFollowing.begin(), kOfFollowing.end(), fault) != kOfFollowing.end();
  return is_of_following && !moves_machine ? characterise_anew() : "eha read";
}

std::optional<std::string> fit_of_run(const fs::path& folder) {
  try {
    const identify::Source source = identify::load_source(folder.string(), {}, {}, {});
    ident::FitOptions options = identify::task_of(source).options;
    std::string command = "eha fit " + shell_word(folder.string());
    ident::check_record(source.record, options);
    try {
      static_cast<void>(ident::fit_rows(source.record, options));
      return command;
    } catch (const DataError&) {
      options.discard_s = 0.0;
      static_cast<void>(ident::fit_rows(source.record, options));
      return command + " --discard 0";
    }
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

std::string again_as_run(const fs::path& folder, const std::string& experiment, bool asked_service) {
  using Json = nlohmann::ordered_json;
  RunCommand run;
  const Json other = record::read_manifest(folder).other;
  const auto text = [&](const char* place) {
    const Json::json_pointer pointer(place);
    return other.contains(pointer) && other.at(pointer).is_string() ? other.at(pointer).get<std::string>()
                                                                    : std::string();
  };
  run.fast = text("/time_base") == "virtual";
  run.local = run.fast || (text("/device/backend") == "sim" && !asked_service);
  const fs::path file = text("/rig/file");
  const std::optional<fs::path> usual = default_rig_file();
  std::error_code ignored;
  const bool is_usual = usual && fs::equivalent(file, *usual, ignored);
  if (run.local && !is_usual && fs::is_regular_file(file, ignored)) run.rig_file = short_path(file);
  if (run.local) run.output = short_path(fs::absolute(folder, ignored).parent_path());
  return again(run, experiment);
}

std::string partial_record_text(const fs::path& folder) {
  const std::string place = fmt::format("the partial record is in {}", folder.string());
  if (const auto fit = fit_of_run(folder)) return fmt::format("{}; `{}` fits it", place, *fit);
  if (!has_rows(folder)) {
    return fmt::format("the run ended before its first row; {} has its log alone", folder.string());
  }
  return fmt::format("{}; it is too short to fit, `eha plot {}` shows it", place, shell_word(folder.string()));
}

std::string kept_record_text(const fs::path& folder) {
  const std::string place = fmt::format("the partial record is in {}", folder.string());
  try {
    static_cast<void>(record::read_manifest(folder));
  } catch (const Error&) {
    return place;  // a folder that the caller may not read
  }
  if (!has_rows(folder)) return partial_record_text(folder);
  return fmt::format("{}; `eha plot {}` shows it", place, shell_word(folder.string()));
}

std::optional<fs::path> recommended_model(const fs::path& folder) {
  const nlohmann::ordered_json other = record::read_manifest(folder).other;
  const nlohmann::ordered_json::json_pointer place("/identification/recommendation/model");
  if (!other.contains(place) || !other.at(place).is_string()) return std::nullopt;  // null: none is recommended
  const fs::path file = folder / record::kModelsFolder / (other.at(place).get<std::string>() + ".json");
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return std::nullopt;
  return file;
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

/// " --sheet RUN" of the newest valve sheet of the same rig beside a run; empty without one, or if the valve has
/// changed since.
std::string sheet_option(const fs::path& folder, const ident::Model& model) {
  const auto run = newest_sheet_run(folder);
  if (!run) return {};
  const auto sheet = valve_of_sheet(*run);
  if (model.input_map && sheet && !is_of_one_valve(model, *sheet)) return {};
  return " --sheet " + shell_word(run->string());
}

/// " -o controller-2.toml" where the file that `eha tune` writes by default is there; it overwrites none.
std::string output_option() {
  constexpr const char* kUsual = "controller.toml";
  const std::string free = free_name(kUsual);
  return free == kUsual ? "" : " -o " + free;
}

}  // namespace

std::optional<std::string> tune_of_run(const fs::path& folder, const std::optional<std::string>& rig_file) {
  const auto model = recommended_model(folder);
  if (!model) return std::nullopt;
  return "eha tune " + shell_word(folder.string()) + (rig_file ? " --rig " + shell_word(*rig_file) : "") +
         sheet_option(folder, model_in(*model)) + output_option();
}

std::string tune_of_model(const fs::path& model, const fs::path& run) {
  return "eha tune " + shell_word(model.string()) + sheet_option(run, model_in(model)) + output_option();
}

}  // namespace eha::cli
