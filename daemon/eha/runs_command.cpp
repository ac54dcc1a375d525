// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "config/rig_config.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/terminal_text.hpp"
#include "daemon/control/client.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/following_trip.hpp"
#include "daemon/eha/following_warning.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/rehearsal_text.hpp"
#include "daemon/eha/run_argument.hpp"
#include "daemon/eha/service_command.hpp"
#include "daemon/eha/service_text.hpp"
#include "daemon/eha/short_report.hpp"
#include "daemon/eha/terminal_table.hpp"
#include "daemon/eha/track_report.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/recover.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_summary.hpp"
#include "daemon/report/html.hpp"
#include "daemon/sheet/run_sheet.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct RunsListCommand {
  std::optional<std::filesystem::path> folder = {};  ///< none: "runs", or the service's where that is not there
  std::optional<std::filesystem::path> socket = {};  ///< ask this service
  bool all = false;                                  ///< placings that reached their place, too
};

struct RunsShowCommand {
  std::filesystem::path run;  ///< folder, or its name in ./runs or among the service's
  std::filesystem::path socket = control::default_socket();
};

struct RunsRecoverCommand {
  std::filesystem::path target;  ///< one run folder, or a folder of them
};

struct RunList {
  std::string folder;
  std::vector<record::RunSummary> runs;
};

std::string verdict_of(const record::RunSummary& run) {
  if (run.purpose == record::Purpose::placing) return "a move to a place";
  if (run.purpose == record::Purpose::valve_sheet) {
    if (run.outcome == record::kInProgress) return "-";
    std::error_code error;
    const bool has_sheet = fs::exists(fs::path(run.folder) / sheet::kSheetFile, error);
    return has_sheet || error ? "a valve sheet"
                              : fmt::format("no valve sheet: eha characterise {} says why", shell_word(run.folder));
  }
  if (run.purpose == record::Purpose::tracking) return "a controller's trial";
  if (run.models.empty()) return "not fitted";
  std::vector<std::string> accepted;
  for (const record::ModelEntry& model : run.models) {
    if (model.name == run.recommended) {
      return fmt::format("recommended: {} ({})", model.name, model.grade.empty() ? "accepted" : model.grade);
    }
    if (model.accepted) accepted.push_back(model.name);
  }
  return accepted.empty() ? "none accepted" : fmt::format("none recommended; accepted: {}", fmt::join(accepted, ", "));
}

/// Writes the end of the loop, its cause where the record shows it, and the counters.
void show_report(const record::ReportEntry& report, const fs::path& run, Console& console) {
  const std::string description = report.description.empty() || !shows_its_cause(run)
                                      ? report.description
                                      : record::without_remedy(report.description);
  for (const std::string& text : {description, cause_of_trip(run, console), report.write_error}) {
    if (!text.empty()) console.print(fmt::format("         {}", text));
  }
  const acquisition::LoopCounters& counters = report.counters;
  console.print(fmt::format("ticks    {}: {} late, {} skipped, {} sample{} not delivered, {} dropped, {} clamped",
                            counters.ticks, counters.late, counters.skipped, counters.timeouts,
                            counters.timeouts == 1 ? "" : "s", counters.dropped, counters.clamped));
}

/// "52.1 s, ramps included, of \"paper\" on simulated rig, begun 2026-11-22 10:15:00 UTC"; empty for a run without a
/// row.
std::string recorded_text(const fs::path& run, const record::Manifest& manifest) {
  const record::RunSummary summary = record::summary_of(run.string(), manifest);
  if (!(summary.recorded_s > 0.0)) return {};
  const auto text_at = [&](const char* pointer) {
    const Json::json_pointer at(pointer);
    const bool is_text = manifest.other.contains(at) && manifest.other.at(at).is_string();
    return is_text ? one_line(manifest.other.at(at).get<std::string>()) : std::string();
  };
  const std::string rig = text_at("/rig/name");
  return fmt::format("{:.1f} s, ramps included, of \"{}\"{}, begun {}", summary.recorded_s, text_at("/name"),
                     rig.empty() ? "" : " on " + rig, report::utc_text(text_at("/utc_start")));
}

/// The fault of a run whose process was killed before it wrote a report, by what it had written; empty without one.
std::string fault_without_report(const record::Manifest& manifest) {
  const Json fault = manifest.report ? Json() : record::fault_of(manifest);
  if (fault.is_null()) return {};
  const bool has_jumped = record::reading_jumped(manifest);
  return fmt::format(
      "{}{}: its process ended before the report was written{}", one_line(fault.at("cause").get<std::string>()),
      fault.contains("at_s") && fault.at("at_s").is_number()
          ? fmt::format(" at {:.3f} s", fault.at("at_s").get<double>())
          : " by its rows",
      has_jumped ? fmt::format("; the rod may stand elsewhere than its sensor shows it: mend the sensor, "
                               "{}",
                               acquisition::kCompareWithRuler)
                 : "");
}

/// Why no valve sheet comes from a run that was to measure one; empty where it has one, or was not to.
std::string why_no_sheet(const fs::path& run, const record::Manifest& manifest) {
  if (record::purpose_of(manifest) != record::Purpose::valve_sheet || !manifest.outcome) return {};
  std::error_code ignored;
  if (fs::exists(run / sheet::kSheetFile, ignored)) return {};
  try {
    static_cast<void>(sheet::sheet_of_run(record::OpenRun(run), sheet::SheetRuns::cut_as_well));
    return {};
  } catch (const Error& error) {
    return error.what();
  }
}

/// Returns the runs that ehad keeps.
RunList runs_of_service(const fs::path& socket) {
  const Json answer = control::Client(socket).call("runs");
  RunList list{.folder = answer.at("folder"), .runs = {}};
  for (const Json& run : answer.at("runs")) list.runs.push_back(record::summary_from_json(run, "ehad's answer"));
  return list;
}

/// Returns the service's present work on its runs, by their names.
std::map<std::string, std::string> progress_of_service(const fs::path& socket) {
  std::map<std::string, std::string> progress;
  const Json queue = control::Client(socket).call("queue", {{"over", 0}});
  for (const Json& entry : queue.at("entries")) {
    if (const std::string text = progress_text(entry); !text.empty()) progress[entry.value("run", "")] = text;
  }
  return progress;
}

/// @throws IoError, PermissionError  the folder does not exist or cannot be read
void require_folder(const fs::path& folder) {
  std::error_code error;
  if (fs::exists(folder, error)) return;
  if (error) os::throw_system_error("look at", folder, error.value());
  throw IoError(fmt::format("{}: no such folder; `eha runs list` names the runs in ./runs", folder.string()));
}

RunList runs_of_folder(const fs::path& folder, const Console& console) {
  RunList list{.folder = folder.string(), .runs = {}};
  for (const fs::path& run : record::list_runs(folder)) {
    try {
      list.runs.push_back(record::summary_of(run.string(), record::read_manifest(run)));
    } catch (const Error& error) {
      // A damaged run must not hide the others.
      console.warning(error.what());
      list.runs.push_back({.folder = run.string(), .outcome = "unreadable"});
    }
  }
  return list;
}

Json to_json(const RunList& list) {
  Json document{{"schema", "eha-runs/1"}, {"folder", list.folder}, {"runs", Json::array()}};
  for (const record::RunSummary& run : list.runs) document["runs"].push_back(to_json(run));
  return document;
}

/// Whether `eha runs recover` has work in the folder; false if it cannot be read, because this is only for a hint.
bool has_torn_run(const fs::path& folder) {
  try {
    return !record::find_torn_runs(folder).empty();
  } catch (const Error&) {
    return false;
  }
}

/// Says in one line where the service keeps its runs, for a list of others. Nothing without a service, or if the list
/// is its own.
void name_runs_of_service(const fs::path& listed, const Console& console) {
  const fs::path socket = control::default_socket();
  const fs::path folder = run_folder_of_service(socket);
  std::error_code ignored;
  if (folder.empty() || fs::equivalent(folder, listed, ignored)) return;
  console.info(fmt::format("these are the runs in {}; the service keeps its own in {}: eha runs --socket {}",
                           listed.string(), folder.string(), shell_word(socket.string())));
}

/// Says which run `latest` is, and why no later one with an accepted model is it.
void name_latest(const RunList& list, const Console& console) {
  std::error_code ignored;
  const fs::path latest = fs::read_symlink(fs::path(list.folder) / record::kLatestLink, ignored);
  std::string text =
      latest.empty() ? "no run is latest" : fmt::format("latest is {}", one_line(latest.filename().string()));
  bool is_told = !latest.empty();
  for (auto run = list.runs.rbegin(); run != list.runs.rend(); ++run) {
    const fs::path folder = run->folder;
    if (folder.filename() == latest.filename()) break;
    if (std::none_of(run->models.begin(), run->models.end(), [](const auto& model) { return model.accepted; })) {
      continue;
    }
    try {
      const std::string against = record::reason_against_latest(record::read_manifest(folder));
      if (against.empty()) break;
      text += fmt::format(", not {}: {}", one_line(folder.filename().string()), against);
      is_told = true;
    } catch (const Error& error) {
      console.debug(error.what());
    }
    break;
  }
  if (is_told) console.print(text);
}

ExitCode execute(const RunsListCommand& command, Console& console) {
  // Returns the runs without a given folder: those in ./runs, or the service's if that folder does not exist.
  const fs::path here = command.folder.value_or("runs");
  std::error_code ignored;
  const bool asks_service = command.socket || (!command.folder && !fs::exists(here, ignored) &&
                                               fs::exists(control::default_socket(), ignored));
  if (command.folder && !asks_service) require_folder(*command.folder);
  const RunList list = asks_service ? runs_of_service(command.socket.value_or(control::default_socket()))
                                    : runs_of_folder(here, console);
  console.print_json(to_json(list));
  if (!asks_service) name_runs_of_service(here, console);
  if (list.runs.empty()) {
    console.print(fmt::format("no runs in {}", list.folder));
    console.next_step(asks_service ? through(command.socket.value_or(control::default_socket()),
                                             "eha run " + shell_word(an_experiment()))
                                   : suggest::run(simulated_access({}), {an_experiment()}));
    return ExitCode::ok;
  }
  std::vector<std::vector<std::string>> rows;
  std::map<std::string, std::string> progress;
  if (asks_service) progress = progress_of_service(command.socket.value_or(control::default_socket()));
  std::size_t left_out = 0;
  std::string last = list.runs.back().folder;
  for (const record::RunSummary& run : list.runs) {
    const bool is_done = acquisition::is_whole(run.outcome) && run.fault.empty();
    if (!command.all && run.purpose == record::Purpose::placing && is_done) {
      ++left_out;
      continue;
    }
    last = run.folder;
    const std::string name = fs::path(run.folder).filename().string();
    const auto under_way = progress.find(name);
    rows.push_back({name, run.fault.empty() ? run.outcome : run.outcome + ": " + run.fault,
                    run.recorded_s > 0.0 ? fmt::format("{:.1f}", run.recorded_s) : "-",
                    under_way != progress.end() ? under_way->second : verdict_of(run)});
  }
  console.print(
      text_table({{"run", Align::left}, {"outcome", Align::left}, {"s", Align::right}, {"models", Align::left}}, rows));
  if (left_out > 0) {
    console.print(fmt::format("{} move{} to a place left out; --all lists {}", left_out, left_out == 1 ? "" : "s",
                              left_out == 1 ? "it" : "them"));
  }
  name_latest(list, console);
  if (!asks_service && has_torn_run(here)) {
    console.next_step("eha runs recover " + shell_word(here.string()));
    return ExitCode::ok;
  }
  console.next_step("eha runs show " + shell_word(last));
  return ExitCode::ok;
}

/// Whether a fault is of the rod, its sensor or valve; those of the card and of late ticks are for `eha doctor`.
bool is_of_rod(const Trip& trip) {
  using acquisition::Fault;
  constexpr std::array kOthers{Fault::frozen_sensor, Fault::feedback_band, Fault::feedback_rail, Fault::sensor_slip,
                               Fault::wrong_place};
  // Also where the reading jumps, which no [following] makes.
  return may_be_of_following({.fault = trip.fault}) || std::any_of(kOthers.begin(), kOthers.end(), [&](Fault one) {
           return acquisition::to_text(one) == trip.fault;
         });
}

/// The rig of a run; none where its file cannot be read.
std::optional<config::RigConfig> rig_of(const Json& manifest) {
  try {
    return config::parse_rig(manifest.at("rig").at("text").get<std::string>(), "run.json");
  } catch (const Json::exception&) {
    return std::nullopt;
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// Returns the next commands for a run. @param entry  of the service's queue; null if no service has the run
std::vector<std::string> next_of(const RunsShowCommand& command, const record::Manifest& manifest, const Json& entry,
                                 const Console& console) {
  const std::string run = shell_word(command.run.string());
  const std::string state = entry.is_object() ? entry.value("state", "") : "";
  if (state == "running") return {through(command.socket, "eha status --watch")};
  if (!manifest.outcome) return {"eha runs recover " + run};
  if (state == "fitting" || state == "judging") return {through(command.socket, "eha queue")};
  const record::Purpose purpose = record::purpose_of(manifest);
  const bool is_whole = acquisition::is_whole(*manifest.outcome);
  const bool is_fitted = purpose == record::Purpose::models || (purpose == record::Purpose::tracking && is_whole);
  const Trip trip = trip_of(manifest);
  const auto after_trip = [&] {
    const auto of_run = rig_of(manifest.other);
    return next_after_trip(trip, of_run ? &*of_run : nullptr, console.rig());
  };
  if (!has_rows(command.run)) {  // nothing to fit or to draw
    const bool is_wanted = *manifest.outcome == acquisition::Outcome::interrupted ||
                           trip.fault == acquisition::to_text(acquisition::Fault::second_stop);
    if (is_wanted) return {through(command.socket, "eha status")};
    return {is_of_rod(trip) ? after_trip() : "eha doctor"};
  }
  // As after the run: its experiment is the command's own, and has nothing to fit.
  if (!is_whole && is_of_rod(trip) &&
      (purpose == record::Purpose::placing || purpose == record::Purpose::valve_sheet)) {
    return {warn_of_unused_sheet(command.run, console).value_or(after_trip()), "eha plot " + run};
  }
  if (purpose == record::Purpose::tracking && !is_whole) return {"eha track " + run};  // says what the trial shows
  const std::optional<std::string> fit = is_fitted ? fit_of_run(command.run) : std::nullopt;
  std::vector<std::string> next{report_of_run(command.run, fit ? *fit : "eha plot " + run)};
  // A record in which the rod did not follow tells nothing of it.
  if (!is_whole && is_of_rod(trip)) return {next.front(), after_trip()};
  if (fit && next.front() != *fit && !is_whole) next.push_back(*fit);
  return next;
}

ExitCode execute(const RunsShowCommand& given, Console& console) {
  RunsShowCommand command = given;
  const NamedRun named = run_named(given.run.string(), given.socket);
  if (!named.note.empty()) console.info(named.note);
  command.run = named.path;
  if (std::error_code unknown; !command.run.has_parent_path() && !fs::exists(command.run, unknown) && !unknown) {
    throw IoError(fmt::format("{}: no run of this name in ., in ./runs or with the service; `eha runs` lists them",
                              command.run.string()));
  }
  const record::Manifest manifest = record::read_manifest(command.run);
  console.set_rig(access_of_run(command.run));
  console.print_json(record::to_json(manifest));
  console.print(fmt::format("run      {}", command.run.string()));
  console.print(fmt::format("outcome  {}", record::outcome_text(manifest)));
  if (const std::string recorded = recorded_text(command.run, manifest); !recorded.empty()) {
    console.print("recorded " + recorded);
  }
  if (manifest.recovery) {
    console.print(fmt::format("         {} rows recovered from the journal, {} torn bytes left out",
                              manifest.recovery->rows, manifest.recovery->torn_bytes));
    for (const record::JournalGap& gap : manifest.recovery->gaps) {
      console.print(fmt::format("         {} rows lost at {:.3f} s, where the journal is damaged", gap.rows,
                                static_cast<double>(gap.at_ns) * 1e-9));
    }
  }
  if (manifest.report) show_report(*manifest.report, command.run, console);
  if (const std::string fault = fault_without_report(manifest); !fault.empty()) {
    console.print("         " + fault);
  }
  const Json entry = entry_of_run(command.run, command.socket);
  if (const std::string text = progress_text(entry); !text.empty()) console.print("service  the run " + text);
  print_answer(command.run, manifest, console);
  if (const std::string why = why_no_sheet(command.run, manifest); !why.empty()) {
    console.print("sheet    " + why);
  }
  const std::string against = record::reason_against_latest(manifest);
  if (!against.empty() && manifest.identification && manifest.identification->accepted) {
    console.print("latest   another run: " + against);
  }
  for (const std::string& step : next_of(command, manifest, entry, console)) console.next_step(step);
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
                                  {"lost_rows", recovery.lost_rows},
                                  {"gaps", recovery.gaps},
                                  {"torn_bytes", recovery.torn_bytes}});
      console.print(recovery.changed ? record::describe(run, recovery)
                                     : fmt::format("{}: complete, nothing to do", one_line(run.string())));
    } catch (const Error& error) {
      // A run that cannot be recovered must not prevent the recovery of others.
      console.error(error.what());
      document["runs"].push_back({{"folder", run.string()}, {"changed", false}, {"error", error.what()}});
      if (code == ExitCode::ok) code = error.exit_code();
    }
  }
  if (runs.empty()) console.print(fmt::format("no torn runs in {}", command.target.string()));
  console.print_json(document);
  if (!runs.empty() && code == ExitCode::ok) {
    if (const auto fit = fit_of_run(runs.front())) console.next_step(*fit);
  }
  return code;
}

}  // namespace

void add_runs(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("runs", "List, show, recover, cancel, acknowledge or remove runs");
  sub->fallthrough();
  sub->require_subcommand(0, 1);
  sub->footer(
      "\nWithout a folder it lists ./runs, with --socket the runs of the service.\n\nExamples:\n  eha runs list\n"
      "  eha runs --socket /run/ehad/ehad.sock\n  eha runs show runs/latest\n  eha runs recover runs");
  // Without a subcommand it lists. Other subcommands have a --socket of their own.
  const auto listing = std::make_shared<RunsListCommand>();
  add_socket_option(*sub, listing->socket);
  constexpr const char* kAllHelp = "Also moves to a place that came there";
  sub->add_flag("--all", listing->all, kAllHelp);
  sub->callback([sub, listing, &line] {
    if (sub->get_subcommands().empty()) line.command = Request<RunsListCommand>{*listing};
  });
  CLI::App* list = sub->add_subcommand("list", "One line for each run, oldest first; also without `list`");
  list->callback([listing, &line] { line.command = Request<RunsListCommand>{*listing}; });
  list->add_option("folder", listing->folder, "Folder of run folders (default runs, else the service's)")
      ->type_name("DIR");
  add_socket_option(*list, listing->socket);
  list->add_flag("--all", listing->all, kAllHelp);
  CLI::App* show = sub->add_subcommand("show", "Show outcome, models and verdicts of a run");
  auto& shown = options_of<RunsShowCommand>(*show, line);
  show->add_option("run", shown.run, "Run folder, or its name")->required()->type_name("RUN");
  add_socket_option(*show, shown.socket);
  CLI::App* recover = sub->add_subcommand("recover", "Complete runs whose process died, from their journals");
  auto& recovered = options_of<RunsRecoverCommand>(*recover, line);
  recover->add_option("target", recovered.target, "Run folder, or folder of run folders")
      ->required()
      ->type_name("RUN|DIR");
  CLI::App* cancel = sub->add_subcommand("cancel", "Remove a waiting or held experiment from the service's queue");
  auto& cancelled = options_of<ServiceCommand>(*cancel, line, {.method = "cancel"});
  add_entries(*cancel, cancelled, "Numbers in the queue, see eha queue")->required();
  add_socket_option(*cancel, cancelled.socket);
  CLI::App* ack = sub->add_subcommand("ack", "Acknowledge the incident of a run; retention may then remove the run");
  auto& acknowledged = options_of<ServiceCommand>(*ack, line, {.method = "ack"});
  ack->add_option("run", acknowledged.run, "Run folder, or its name")->required()->type_name("RUN");
  add_socket_option(*ack, acknowledged.socket);
  CLI::App* remove = sub->add_subcommand("remove", "Delete a run of the service, its record and models");
  auto& removed = options_of<ServiceCommand>(*remove, line, {.method = "remove"});
  remove->add_option("run", removed.run, "Run folder, or its name")->required()->type_name("RUN");
  remove->add_flag("--yes", removed.yes, "Without asking");
  add_socket_option(*remove, removed.socket);
}

}  // namespace eha::cli
