// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/run_service.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "config/controller_config.hpp"
#include "config/file_kind.hpp"
#include "config/prepared_experiment.hpp"
#include "config/tone_grid.hpp"
#include "core/error.hpp"
#include "daemon/control/client.hpp"
#include "daemon/eha/controller_argument.hpp"
#include "daemon/eha/following_trip.hpp"
#include "daemon/eha/following_warning.hpp"
#include "daemon/eha/model_list.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/place_text.hpp"
#include "daemon/eha/rehearsal_text.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/ruler.hpp"
#include "daemon/eha/run_command.hpp"
#include "daemon/eha/run_follower.hpp"
#include "daemon/eha/sheet_answer.hpp"
#include "daemon/eha/short_report.hpp"
#include "daemon/eha/stop_on_signals.hpp"
#include "daemon/eha/track_report.hpp"
#include "daemon/identify/publish.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;
using control::Client;

/// A file of the command line.
struct ExperimentFile {
  std::string name;
  std::string text;
};

/// Prints the answer as `eha run --local` does, from the run's folder; the list of models if the folder is not
/// readable.
void print_answer_of_service(const Json& entry, const Console& console) {
  const std::filesystem::path folder = entry.value("folder", "");
  try {
    if (!folder.empty() && print_answer(folder, record::read_manifest(folder), console)) return;
  } catch (const Error& error) {
    console.debug(error.what());
  }
  print_model_list(record::models_from_json(entry.at("models"), "ehad's answer: models"), console);
}

/// Returns the purpose of a run; models if its folder is not readable.
record::Purpose purpose_of(const std::string& folder, const Console& console) {
  try {
    return record::purpose_of(record::read_manifest(folder));
  } catch (const Error& error) {
    console.debug(error.what());
    return record::Purpose::models;
  }
}

/// Whether the following runs may start: this one completed, with or without an accepted model.
bool has_completed(const Json& entry) { return acquisition::is_whole(entry.value("outcome", "")); }

/// A fault, a stop and a refused start disarm the rig: the next motion needs `eha arm`.
void learn_if_disarmed(const RunCommand& command, Console& console) {
  try {
    suggest::RigAccess rig = console.rig();
    rig.is_disarmed = Client(command.socket).call("status").at("state") != "armed";
    console.set_rig(std::move(rig));
  } catch (const Error& error) {
    console.debug(error.what());
  }
}

/// @param rig  as the service's status has it
/// The page of a run that ended early: the service writes none, and this user may not write into the run's folder.
std::string page_of_ended(const std::filesystem::path& folder) {
  const std::string page = free_name(folder.filename().string() + ".html");
  return report_of_run(folder, fmt::format("eha report {} -o {}", shell_word(folder.string()), shell_word(page)));
}

ExitCode report(const Json& entry, const Json& rig, const RunCommand& command, Console& console) {
  const std::string units = rig.value("units", "");
  const auto code = static_cast<ExitCode>(entry.value("exit_code", static_cast<int>(ExitCode::bug)));
  const std::string folder = entry.value("folder", "");
  std::string note = entry.value("note", "");
  if (!has_completed(entry)) learn_if_disarmed(command, console);
  for (const Json& sentence : entry.value("warnings", Json::array())) console.warning(sentence.get<std::string>());
  const bool is_done = code == ExitCode::ok || code == ExitCode::model_rejected;
  const record::Purpose purpose = is_done ? purpose_of(folder, console) : record::Purpose::models;
  if (code == ExitCode::ok && purpose == record::Purpose::valve_sheet) {
    std::optional<NewRigFile> rig_file;
    if (command.new_rig_file)
      rig_file = NewRigFile{.path = *command.new_rig_file, .replaces = rig.value("file", ""), .socket = command.socket};
    return show_valve_sheet(record::OpenRun(folder), SheetFiles::keep, rig_file, console);
  }
  if (purpose == record::Purpose::tracking) return show_track(record::OpenRun(folder), TrackFiles::keep, console);
  const bool has_following = rig.value("characterised", false);
  const bool measured_valve =
      code == ExitCode::safety_trip && purpose_of(folder, console) == record::Purpose::valve_sheet;
  if (measured_valve && !has_following) note = without_causes_of_following(std::move(note));
  if (code != ExitCode::ok && !note.empty()) {
    console.error(!folder.empty() && shows_its_cause(folder) ? record::without_remedy(note) : note);
  }
  const Trip trip = folder.empty() ? Trip{} : trip_of_run(folder);
  if (measured_valve) {
    const std::string file = rig.value("file", "");
    const WayOut way_out = has_following ? WayOut{way_out_of_following(trip, file, console.rig()), {}}
                                         : way_out_without_following(trip, file);
    if (!way_out.sentence.empty()) console.info(way_out.sentence);
    if (!way_out.lines.empty()) console.print(way_out.lines);
  }
  const bool has_tripped = code == ExitCode::safety_trip;
  const auto remedy = has_tripped && !folder.empty() ? warn_of_unused_sheet(folder, console) : std::nullopt;
  if (console.rig().is_disarmed && entry.at("state") != "cancelled") {
    const char* arm = entry.value("open_slip", false) ? "eha arm --ruler LENGTH" : "eha arm";
    console.info(fmt::format("the rig is disarmed; `{}` comes before the next motion", through(command.socket, arm)));
  }
  const bool has_other_valve = !folder.empty() && !is_done && explain_trip(folder, console);
  // A placing and a valve sheet trip again with the same [following]; of a machine the sensor is looked at first.
  const bool is_of_table = command.text && has_following && !rig.value("moves", true) && is_first_of_following(trip);
  const std::string after_trip = remedy.value_or(is_of_table       ? suggest::without_following(console.rig())
                                                 : has_other_valve ? suggest::characterise(console.rig())
                                                                   : suggest::read(console.rig()));
  const bool is_ended_trial =
      !folder.empty() && purpose_of(folder, console) == record::Purpose::tracking && !has_completed(entry);
  if (is_ended_trial) {
    console.info(kept_record_text(folder));
  } else if (!folder.empty() && !has_completed(entry)) {
    // A placing and a characterisation, whose experiments the command itself writes, have nothing to fit.
    console.info(command.text ? kept_record_text(folder) : partial_record_text(folder));
  }
  console.print_json({{"schema", "eha-run/1"},
                      {"run", folder},
                      {"outcome", entry.at("state") == "cancelled" ? Json("cancelled") : entry.at("outcome")},
                      {"models", entry.at("models")},
                      {"warnings", entry.value("warnings", Json::array())},
                      {"exit_code", static_cast<int>(code)}});
  if (entry.value("placed_in", Json()).is_number()) {
    if (code == ExitCode::ok) {
      if (!folder.empty()) warn_of_unused_sheet(folder, console);
      print_place(entry.at("placed_in").get<double>(), units, suggest::read(console.rig()), console);
    }
    if (has_tripped) console.next_step(after_trip);
    return code;
  }
  if (is_ended_trial) {
    explain_ended_trial(folder, units, TrackFiles::keep, console, remedy);
    return code;
  }
  print_answer_of_service(entry, console);
  if (has_tripped) console.next_step(after_trip);
  if (!folder.empty() && !has_completed(entry) && has_rows(folder)) console.next_step(page_of_ended(folder));
  if (code == ExitCode::model_rejected) {
    const auto cut = cut_of_run(folder);
    if (cut) console.next_step(*cut);
    if (first_of_run(folder).first == ident::FirstStep::look_at_sensor) console.next_step(suggest::read(console.rig()));
    const std::filesystem::path next = std::filesystem::path(folder) / identify::kNextExperimentFile;
    std::error_code unknown;
    console.next_step(!cut && std::filesystem::exists(next, unknown)
                          ? suggest::run(console.rig(), {next.string()})
                          : report_of_run(folder, "eha runs show " + shell_word(folder)));
  }
  if (code == ExitCode::ok) {
    const ValveNow valve = warn_of_changed_valve(folder, console);
    if (const auto cut = cut_of_run(folder)) console.next_step(*cut);
    console.next_step(report_of_run(folder, "eha runs show " + shell_word(folder)));
    if (valve == ValveNow::changed) {
      console.next_step(suggest::characterise(console.rig()));
    } else if (const auto tune = tune_of_run(folder, console.rig());
               tune && valve == ValveNow::as_known && first_of_run(folder).first == ident::FirstStep::none) {
      console.next_step(*tune);
    }
  }
  return code;
}

/// Rehearses an experiment with the service's rig file, if this user may read it, so that the user sees the travel
/// before the confirmation. Errors in either file are left to the service, which refuses them.
void rehearse_for_service(const ExperimentFile& file, const Json& status, TravelRisk risk, Console& console) {
  std::optional<config::RigConfig> rig;
  std::optional<config::PreparedExperiment> prepared;
  std::optional<Rehearsal> rehearsal;
  double place_in = 0.0;
  try {
    rig = config::load_rig(status.at("rig").at("file").get<std::string>());
    prepared = config::parse_prepared_experiment(file.text, file.name, *rig);
    if (const auto sentence = config::off_grid_tones(prepared->config)) console.warning(*sentence);
    warn_if_not_fittable(prepared->config, *rig, file.name, console);
    warn_if_not_rehearsed(prepared->config, *rig, file.name, console);
    say_motion_shown_first(prepared->config, *rig, console);
    if (!status.at("run").is_null()) {
      if (!rig->limits.following) return;  // nothing rehearses it
      console.info(
          fmt::format("{}: another experiment moves the rod; this one is rehearsed before it begins, from where "
                      "the rod stands then",
                      file.name));
      return;
    }
    const Json rod = status.value("rod", Json());
    const bool is_read = rod.is_object() && rod.contains("displacement_in");
    place_in = is_read ? rod.at("displacement_in").get<double>() : start_of(*rig);
    rehearsal = rehearse(*prepared, *rig, place_in);
  } catch (const Error& error) {
    console.debug(fmt::format("not rehearsed: {}", error.what()));
    return;
  }
  require_within_travel(prepared->config, *rig, place_in, file.name, console);
  report_rehearsal({*prepared, *rig, place_in, rehearsal}, file.name, risk, console);
}

std::vector<ExperimentFile> files_of(const RunCommand& command) {
  std::vector<ExperimentFile> files{
      {command.experiment_file, command.text ? *command.text : config::read_config_file(command.experiment_file)}};
  for (const std::string& name : command.further_files) files.push_back({name, config::read_config_file(name)});
  for (const ExperimentFile& file : files) {
    const bool is_given = command.text && &file == &files.front();
    if (!is_given && config::brings_back(file.text, file.name)) refuse_way_back(file.name);
  }
  std::size_t bytes = 0;
  for (const ExperimentFile& file : files) bytes += file.text.size();
  // The request also holds names, quotes and escapes.
  if (files.size() > 1 && bytes > control::kLongestRequest / 2) {
    throw UsageError(
        fmt::format("the {} experiments have {} bytes together, a request may have {}: queue them with several "
                    "commands and --detach",
                    files.size(), bytes, control::kLongestRequest / 2));
  }
  return files;
}

/// Numbers of this user's experiments in the queue.
std::vector<std::int64_t> own_numbers(Client& client) {
  std::vector<std::int64_t> numbers;
  const Json queue = client.call("queue");
  for (const Json& entry : queue.at("entries")) {
    if (entry.at("uid") == geteuid()) numbers.push_back(entry.at("entry"));
  }
  return numbers;
}

constexpr std::chrono::seconds kSilent{2};  ///< from here on a wait is explained

/// Submits all or none. @param ruler_in  where a ruler shows the rod; none: nobody has read it   @returns their entries
/// @throws control::CallGivenUp  stopped before the service took them
Json submitted(Client& client, const std::vector<ExperimentFile>& files, const RunCommand& command,
               std::optional<double> ruler_in, const StopOnSignals& stop, const Console& console) {
  const auto options = [&command, ruler_in](Json params) {
    if (ruler_in) params["ruler_in"] = *ruler_in;
    params["fast"] = command.fast;
    params["accept_travel_risk"] = command.accept_travel_risk;
    params["detach"] = command.detach;
    return params;
  };
  // The service needs less time to check one experiment than the minute that a call waits by default.
  const auto patience = std::chrono::minutes(1) * files.size();
  const auto begun = std::chrono::steady_clock::now();
  bool is_said = false;
  const auto is_stopped = [&] {
    if (!is_said && std::chrono::steady_clock::now() - begun > kSilent) {
      is_said = true;
      console.info("ehad checks it, at a low priority: that may take a minute an experiment where the machine is busy");
    }
    return !command.detach && stop.count() > 0;
  };
  if (files.size() == 1) {
    return Json::array({client.call("submit", options({{"experiment", files[0].text}, {"name", files[0].name}}),
                                    patience, is_stopped)});
  }
  Json list = Json::array();
  for (const ExperimentFile& file : files) list.push_back({{"experiment", file.text}, {"name", file.name}});
  return client.call("submit", options({{"experiments", std::move(list)}}), patience, is_stopped).at("entries");
}

/// Where somebody else holds the lease what the service says of that; else empty.
std::string lease_of_another(Client& client) {
  const Json lease = client.call("status").at("lease");
  if (lease.is_null() || lease.at("uid") == geteuid()) return {};
  return lease.at("text").get<std::string>();
}

ExitCode leave(Client& client, const Json& entries, const RunCommand& command, const Console& console) {
  console.print_json({{"schema", "eha-queued/1"}, {"entries", entries}});
  for (const Json& entry : entries) {
    console.print(fmt::format("experiment {} \"{}\" is {}", entry.at("entry").get<std::int64_t>(),
                              entry.value("name", ""), entry.at("state").get<std::string>()));
  }
  const Json& first = entries.front();
  const bool is_held = first.at("state") == "held";
  const std::string lease = is_held ? lease_of_another(client) : std::string();
  if (!lease.empty()) {  // `eha arm` would be refused until then
    const std::string what = entries.size() == 1 ? fmt::format(" {}", first.at("entry").get<std::int64_t>()) : "";
    console.info(fmt::format("{}; after that, or their `eha disarm`: `{} && {}`", lease,
                             through(command.socket, "eha arm"), through(command.socket, "eha queue release" + what)));
  } else if (is_held) {
    console.info(entries.size() == 1
                     ? fmt::format("it waits for {}", first.value("waits_for", ""))
                     : fmt::format("they wait for their release: {}", through(command.socket, "eha queue release")));
  }
  const char* verdicts = entries.size() == 1 ? "its verdict once it is fitted" : "their verdicts once they are fitted";
  console.info(fmt::format("{} lists {}", through(command.socket, "eha queue"), verdicts));
  if (!lease.empty()) return ExitCode::ok;
  console.next_step(is_held ? through(command.socket, "eha arm") : through(command.socket, "eha status --watch"));
  return ExitCode::ok;
}

/// The command that the user has given, for the rig.
std::string as_given(const suggest::RigAccess& rig, const RunCommand& command) {
  if (!command.controller_file.empty()) {
    const config::ControllerConfig controller = config::load_controller(command.controller_file);
    return suggest::track(access_of_controller(command.controller_file, controller), command.controller_file);
  }
  if (command.experiment_file == kCharacterising) return suggest::characterise(rig);
  std::vector<std::string> experiments{command.experiment_file};
  experiments.insert(experiments.end(), command.further_files.begin(), command.further_files.end());
  return suggest::run(rig, experiments);
}

}  // namespace

void refuse_way_back(const std::string& file) {
  throw UsageError(fmt::format(
      "{}: way_back moves the rod from beyond a travel limit, where a person must have seen it: `eha goto` asks",
      file));
}

ExitCode run_through_service(const RunCommand& command, Console& console) {
  const std::vector<ExperimentFile> files = as_a_list(command, "queued", [&] { return files_of(command); });
  std::optional<Client> connected;
  try {
    connected.emplace(command.socket);
  } catch (const DeviceError& error) {
    if (!default_rig_moves_machine()) {
      RunCommand local = command;
      local.local = true;
      throw DeviceError(
          fmt::format("`{}` plays it on the simulated rig, without the service. Where ehad drives a rig: {}",
                      as_given(access_of(local), command), error.what()));
    }
    throw DeviceError(fmt::format(
        "{}. Only where ehad drives no rig: the same command with --local plays it in this process", error.what()));
  }
  Client& client = *connected;
  const Json status = client.call("status");
  const Json& rig = status.at("rig");
  warn_if_edited(rig, command.socket, console);
  if (!command.controller_file.empty()) {  // made anew for the rig file in force, not for that of the model's run
    suggest::RigAccess access = console.rig();
    access.rig_file = rig.at("file");
    console.set_rig(std::move(access));
  }
  const std::string units = rig.value("units", "");
  const TravelRisk risk = command.accept_travel_risk ? TravelRisk::accept : TravelRisk::refuse;
  std::optional<double> ruler_in;
  as_a_list(command, "queued", [&] {
    for (auto file = files.begin(); file != files.end(); ++file) {
      const bool is_copy =
          std::any_of(files.begin(), file, [&](const auto& other) { return other.text == file->text; });
      if (!is_copy) rehearse_for_service(*file, status, risk, console);
    }
    if (std::any_of(files.begin(), files.end(),
                    [](const ExperimentFile& file) { return config::characterises(file.text, file.name); })) {
      ruler_in = agreed_ruler(command, command.ruler, console);
    }
  });
  std::vector<std::string> names;
  for (const ExperimentFile& file : files) names.push_back(file.name);
  if (rig.at("moves") == true && !command.yes &&
      !console.confirm(fmt::format("This moves the actuator of \"{}\" ({}) with {}.", rig.at("name").get<std::string>(),
                                   rig.at("file").get<std::string>(), fmt::join(names, ", ")))) {
    console.info("not confirmed; nothing was moved");
    return ExitCode::interrupted;
  }
  // From here on Ctrl-C stops the rig; closing the terminal does not.
  StopOnSignals stop(Driver::service);
  const std::vector<std::int64_t> before = own_numbers(client);
  Json entries;
  try {
    entries = submitted(client, files, command, ruler_in, stop, console);
  } catch (const control::ConnectionLost&) {
    throw;
  } catch (const control::CallGivenUp&) {
    // The service drops what it still checks when the connection ends; it may have queued it in this very moment.
    Client other(command.socket);
    std::vector<std::int64_t> taken;
    for (const std::int64_t number : own_numbers(other)) {
      if (std::find(before.begin(), before.end(), number) == before.end()) taken.push_back(number);
    }
    if (!taken.empty()) {
      RunFollower(command.socket, other, taken, console.unit(units), console).pass_on_stop(stop.signal());
      return ExitCode::interrupted;
    }
    console.info("interrupted before it was queued; nothing was moved");
    return ExitCode::interrupted;
  } catch (const Error& error) {
    rethrow_of_list(error, command, "queued");
  }
  std::vector<std::int64_t> queued;
  for (const Json& entry : entries) {
    queued.push_back(entry.at("entry"));
    if (command.detach) continue;
    console.info(fmt::format("experiment {} \"{}\" on {} ({})", queued.back(), entry.at("name").get<std::string>(),
                             rig.at("name").get<std::string>(), rig.at("file").get<std::string>()));
  }
  if (command.detach) return leave(client, entries, command, console);
  RunFollower follower(command.socket, client, queued, console.unit(units), console);
  if (queued.size() == 1) {
    const auto entry = follower.follow(queued[0], stop, RunFollower::Held::wait);
    return entry ? report(*entry, rig, command, console) : ExitCode::interrupted;
  }
  console.keep_documents();
  ExitCode code = ExitCode::ok;
  bool goes_on = true;
  std::vector<std::int64_t> held;
  for (const std::int64_t one : queued) {
    // After a fault or a stop the service holds the waiting experiments.
    const auto entry = follower.follow(one, stop, goes_on ? RunFollower::Held::wait : RunFollower::Held::leave);
    if (!entry) {
      code = ExitCode::interrupted;
      break;
    }
    if (entry->at("state") == "held") {
      held.push_back(one);
      console.print(fmt::format("{} \"{}\": held", one, entry->value("name", "")));
      continue;
    }
    const std::string outcome = entry->value("outcome", "");
    const std::string end = has_completed(*entry) ? "" : " " + (outcome.empty() ? entry->value("state", "") : outcome);
    console.print(fmt::format("{} \"{}\":{}", one, entry->value("name", ""), end));
    const ExitCode own = report(*entry, rig, command, console);
    if (code == ExitCode::ok) code = own;
    goes_on = goes_on && has_completed(*entry);
  }
  const Json documents = console.taken_documents();
  console.print_json({{"schema", "eha-run-list/1"}, {"runs", documents}, {"exit_code", static_cast<int>(code)}});
  if (!held.empty()) {
    const std::string numbers = fmt::format("{}", fmt::join(held, " "));
    console.info(fmt::format(
        "not played, and held because the experiment before did not complete: {}. `{} && {}` plays {}, `{}` removes {}",
        numbers, through(command.socket, "eha arm"), through(command.socket, "eha queue release " + numbers),
        held.size() == 1 ? "it" : "them", through(command.socket, "eha queue cancel " + numbers),
        held.size() == 1 ? "it" : "them"));
  }
  console.next_step(through(command.socket, "eha queue"));
  return code;
}

}  // namespace eha::cli
