// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <system_error>
#include <vector>

#include "core/os/files.hpp"
#include "daemon/control/client.hpp"
#include "daemon/eha/commands.hpp"
#include "daemon/eha/model_list.hpp"
#include "daemon/eha/text_table.hpp"
#include "daemon/record/recover.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string text_of(const Json& manifest, const char* key) {
  const auto found = manifest.find(key);
  if (found == manifest.end() || found->is_null()) return "-";
  return found->is_string() ? found->get<std::string>() : found->dump();
}

/// The list of models under `identification`, empty when the run was never fitted.
Json models_of(const Json& manifest) {
  const auto identification = manifest.find("identification");
  if (identification == manifest.end() || !identification->is_object()) return Json::array();
  return identification->value("models", Json::array());
}

std::string verdict_of(const Json& models) {
  std::vector<std::string> accepted;
  for (const Json& model : models) {
    if (model.value("accepted", false)) accepted.push_back(model.value("name", "?"));
  }
  if (models.empty()) return "not fitted";
  return accepted.empty() ? "all rejected" : fmt::format("accepted: {}", fmt::join(accepted, ", "));
}

/// What the loop counted, and what it said of its end; nothing for a run without a report (recovered, in progress).
void show_report(const Json& manifest, Console& console) {
  const Json report = manifest.value("report", Json());
  if (!report.is_object()) return;
  for (const char* key : {"description", "write_error"}) {
    const std::string text = report.value(key, "");
    if (!text.empty()) console.print(fmt::format("         {}", text));
  }
  const Json counters = report.value("counters", Json::object());
  const auto count = [&counters](const char* key) { return counters.value(key, std::uint64_t{0}); };
  console.print(fmt::format("ticks    {}: {} late, {} skipped, {} sample{} not delivered, {} dropped, {} clamped",
                            count("ticks"), count("late"), count("skipped"), count("timeouts"),
                            count("timeouts") == 1 ? "" : "s", count("dropped"), count("clamped")));
}

/// What the journal of a run that did not end in an orderly way still held.
void show_recovery(const Json& manifest, Console& console) {
  const Json recovery = manifest.value("recovery", Json());
  if (!recovery.is_object()) return;
  console.print(fmt::format("         {} rows recovered from the journal, {} torn bytes left out",
                            recovery.value("rows", std::uint64_t{0}), recovery.value("torn_bytes", std::uint64_t{0})));
}

/// The runs that ehad keeps.
Json runs_of_service(const fs::path& socket) {
  Json answer = control::Client(socket).call("runs");
  Json document{{"schema", "eha-runs/1"}, {"folder", answer.at("folder")}, {"runs", Json::array()}};
  for (const Json& run : answer.at("runs")) {
    document["runs"].push_back(
        {{"folder", run.at("folder")}, {"outcome", run.at("outcome")}, {"models", run.at("models")}});
  }
  return document;
}

/// @throws IoError, PermissionError  there is none, or it cannot be looked at
void require_folder(const fs::path& folder) {
  std::error_code error;
  if (fs::exists(folder, error)) return;
  if (error) os::throw_system_error("look at", folder, error.value());
  throw IoError(fmt::format("{}: no such folder; `eha runs list` names the runs in ./runs", folder.string()));
}

Json runs_of_folder(const fs::path& folder, const Console& console) {
  Json document{{"schema", "eha-runs/1"}, {"folder", folder.string()}, {"runs", Json::array()}};
  for (const fs::path& run : record::list_runs(folder)) {
    Json manifest;
    try {
      manifest = record::read_manifest(run);
    } catch (const Error& error) {
      // One damaged run must not hide the others.
      console.warning(error.what());
      manifest = Json{{"outcome", "unreadable"}};
    }
    document["runs"].push_back(
        {{"folder", run.string()}, {"outcome", text_of(manifest, "outcome")}, {"models", models_of(manifest)}});
  }
  return document;
}

/// Whether `eha runs recover` has work there. Only for a hint: what cannot be looked at is none.
bool has_torn_run(const fs::path& folder) {
  try {
    return !record::find_torn_runs(folder).empty();
  } catch (const Error&) {
    return false;
  }
}

std::string describe(const fs::path& run, const record::Recovery& recovery) {
  return fmt::format("{}: recovered: {} rows kept, {} torn bytes left out, outcome {}", run.string(), recovery.rows,
                     recovery.torn_bytes, acquisition::to_text(recovery.outcome));
}

}  // namespace

ExitCode execute(const RunsListCommand& command, Console& console) {
  // Without a folder: the runs made here; where there are none, those of the service.
  const fs::path here = command.folder.value_or("runs");
  std::error_code ignored;
  const bool asks_service =
      command.socket || (!command.folder && !fs::exists(here, ignored) && fs::exists(control::kDefaultSocket, ignored));
  if (command.folder && !asks_service) require_folder(*command.folder);
  const Json document =
      asks_service ? runs_of_service(command.socket.value_or(control::kDefaultSocket)) : runs_of_folder(here, console);
  console.print_json(document);
  const Json& runs = document.at("runs");
  if (runs.empty()) {
    console.print(fmt::format("no runs in {}", document.at("folder").get<std::string>()));
    console.next_step(asks_service ? "eha run EXPERIMENT.toml" : "eha run EXPERIMENT.toml --local --fast");
    return ExitCode::ok;
  }
  std::vector<std::vector<std::string>> rows;
  for (const Json& run : runs) {
    rows.push_back({fs::path(run.at("folder").get<std::string>()).filename().string(), text_of(run, "outcome"),
                    verdict_of(run.at("models"))});
  }
  console.print(text_table({{"run", Align::left}, {"outcome", Align::left}, {"models", Align::left}}, rows));
  if (!asks_service && has_torn_run(here)) {
    console.next_step(fmt::format("eha runs recover {}", here.string()));
    return ExitCode::ok;
  }
  console.next_step(fmt::format("eha runs show {}", runs.back().at("folder").get<std::string>()));
  return ExitCode::ok;
}

ExitCode execute(const RunsShowCommand& command, Console& console) {
  const Json manifest = record::read_manifest(command.run);
  console.print_json(manifest);
  console.print(fmt::format("run      {}", command.run.string()));
  console.print(fmt::format("outcome  {}", text_of(manifest, "outcome")));
  show_recovery(manifest, console);
  show_report(manifest, console);
  const Json models = models_of(manifest);
  print_model_list(models, console);
  console.next_step(fmt::format("eha fit {}", command.run.string()));
  return ExitCode::ok;
}

ExitCode execute(const RunsRecoverCommand& command, Console& console) {
  require_folder(command.target);
  const std::vector<fs::path> runs = record::is_run_folder(command.target) ? std::vector<fs::path>{command.target}
                                                                           : record::find_torn_runs(command.target);
  Json document{{"schema", "eha-recovery/1"}, {"runs", Json::array()}};
  ExitCode code = ExitCode::ok;
  for (const fs::path& run : runs) {
    try {
      const record::Recovery recovery = record::recover_run(run);
      document["runs"].push_back({{"folder", run.string()},
                                  {"changed", recovery.changed},
                                  {"outcome", acquisition::to_text(recovery.outcome)},
                                  {"rows", recovery.rows},
                                  {"torn_bytes", recovery.torn_bytes}});
      console.print(recovery.changed ? describe(run, recovery)
                                     : fmt::format("{}: complete, nothing to do", run.string()));
    } catch (const Error& error) {
      // One run that cannot be saved must not cost the others.
      console.error(error.what());
      document["runs"].push_back({{"folder", run.string()}, {"changed", false}, {"error", error.what()}});
      if (code == ExitCode::ok) code = error.exit_code();
    }
  }
  if (runs.empty()) console.print(fmt::format("no torn runs in {}", command.target.string()));
  console.print_json(document);
  if (!runs.empty() && code == ExitCode::ok) console.next_step(fmt::format("eha fit {}", runs.front().string()));
  return code;
}

void recover_torn_runs(const fs::path& folder, Console& console) {
  for (const fs::path& run : record::list_runs(folder)) {
    try {
      if (record::is_torn_run(run)) console.warning(describe(run, record::recover_run(run)));
    } catch (const Error& error) {
      console.warning(fmt::format("{}; it stays as it is", error.what()));
    }
  }
}

}  // namespace eha::cli
