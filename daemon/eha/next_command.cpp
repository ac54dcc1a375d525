// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/next_command.hpp"

#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "daemon/control/socket_path.hpp"
#include "daemon/eha/run_command.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/report/report.hpp"
#include "daemon/sheet/run_sheet.hpp"

namespace eha::cli {

namespace fs = std::filesystem;

std::string shell_word(const std::string& word) {
  const bool plain = !word.empty() && word.find_first_of(" \t\n'\"\\$`*?[]{}()<>|&;#~!") == std::string::npos;
  if (plain) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string through(const std::filesystem::path& socket, std::string command) {
  if (socket != control::default_socket()) command += " --socket " + shell_word(socket.string());
  return command;
}

std::string again(const RunCommand& run, const std::string& experiment) {
  std::string command = "eha run " + shell_word(experiment);
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

std::string report_of_run(const std::filesystem::path& folder, const std::string& otherwise) {
  const std::filesystem::path page = folder / report::kReportFile;
  std::error_code ignored;
  return std::filesystem::exists(page, ignored) ? "xdg-open " + shell_word(page.string()) : otherwise;
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

namespace {

/// " --sheet RUN" of the newest valve sheet of the same rig beside a run; empty without one.
std::string sheet_option(const fs::path& folder) {
  const auto rig_of = [](const fs::path& run) {
    return record::read_manifest(run).other.value(nlohmann::ordered_json::json_pointer("/rig/name"), std::string());
  };
  std::error_code ignored;
  const std::string rig = rig_of(folder);
  std::vector<fs::path> runs = record::list_runs(fs::canonical(folder, ignored).parent_path());
  for (auto run = runs.rbegin(); run != runs.rend(); ++run) {
    if (!fs::is_regular_file(*run / sheet::kSheetFile, ignored) || rig_of(*run) != rig) continue;
    return " --sheet " + shell_word((folder.parent_path() / run->filename()).string());
  }
  return {};
}

}  // namespace

std::optional<std::string> tune_of_run(const fs::path& folder, const std::optional<std::string>& rig_file) {
  if (!recommended_model(folder)) return std::nullopt;
  return "eha tune " + shell_word(folder.string()) + (rig_file ? " --rig " + shell_word(*rig_file) : "") +
         sheet_option(folder);
}

std::string tune_of_model(const fs::path& model, const fs::path& run) {
  return "eha tune " + shell_word(model.string()) + sheet_option(run);
}

}  // namespace eha::cli
