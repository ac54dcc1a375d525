// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/service_command.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "daemon/control/client.hpp"
#include "daemon/control/socket_path.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/length_argument.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/recent_samples.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/rod_status.hpp"
#include "daemon/eha/rod_text.hpp"
#include "daemon/eha/run_line.hpp"
#include "daemon/eha/service_text.hpp"
#include "daemon/eha/stop_on_signals.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;
using control::Client;

constexpr const char* kSocketHelp = "Where ehad listens (default $EHA_SOCKET, otherwise /run/ehad/ehad.sock)";

constexpr std::int64_t kLastPosition = 1000;  // more than the queue holds

constexpr const char* kStatusFooter = R"(
Shows the state of the rig, the rod (length, V) on a bar between its limits, the holder of the lease and its remaining
time [s], the current run (s, V, latency in us), the fit in progress and the queue. A fault, or a run during which ehad
died, is the state until somebody arms the rig. --watch redraws it until Ctrl-C, elsewhere than on a terminal it prints
once a second.

Examples:
  eha status
  eha status --watch)";

constexpr const char* kArmFooter = R"(
Acknowledges earlier faults and arms the rig. For 10 minutes after your last command or run only you may run
experiments and disarm. Arming starts nothing: it lists the held experiments, see eha queue release. After a run that
ended because the sensor's reading jumped (sensor_slip) a machine is armed only with a new calibration, or where a ruler's
reading agrees with the sensor within 1.27 mm (0.05 in). While another user holds the lease only root may take it over:
eha names the holder and what is played, and asks; without a terminal that takes --yes.

Examples:
  eha arm
  eha arm --ruler 74.9mm
  eha arm && eha run config/experiments/paper.toml)";

constexpr const char* kDisarmFooter = R"(
Returns the lease; experiments that wait in the queue are held. During a run use eha stop.

Example:
  eha disarm)";

constexpr const char* kStopFooter = R"(
Anyone may stop the rig. Ramps the current run down to the safe voltage [V]; a second stop makes the rig safe at once.
The record is kept. Afterwards the rig is disarmed, waiting experiments are held, and the lease stays with its holder.

Example:
  eha stop)";

constexpr const char* kMetricsFooter = R"(
Counters and gauges of the service in the text format of Prometheus.

Example:
  eha metrics)";

constexpr const char* kReloadFooter = R"(
Reads rig.toml and ehad.toml again. Refused while the rig is armed, or somebody else holds the lease (whose `eha
disarm` returns it; root may); after a refusal, as of a file with faults, the
configuration read before stays in force. Nothing begins to move while the rig file has narrower limits than those in force,
or is not valid.

Example:
  eha reload)";

constexpr const char* kQueueFooter = R"(
Lists the submitted experiments from top to bottom as they are played: the last five that are over, the newest of them
last, then the one that is played, then what waits; those of one user start in the order listed. A held one starts only after its release.
An experiment is held if you had not armed the rig when you submitted it, if you held it, or if it was waiting at a
fault, a stop, a disarming or a restart. You may hold, release, move and cancel your own; root may hold, move and cancel
all. `eha stop` ends a running one.

Examples:
  eha queue
  eha queue move 7 up
  eha arm && eha queue release 7)";

constexpr const char* kMoveFooter = R"(
Moves an experiment among the waiting and held ones of its submitter. It never delays another user's experiment.

Examples:
  eha queue move 7 up
  eha queue move 7 1)";

struct Verb {
  const char* name;
  const char* help;
  const char* footer;
};

constexpr std::array<Verb, 6> kVerbs{{
    {"status", "Show the state of the service and its rig", kStatusFooter},
    {"arm", "Acknowledge, arm the rig and take the lease", kArmFooter},
    {"disarm", "Disarm the rig and return the lease", kDisarmFooter},
    {"stop", "Stop the current run; anyone may", kStopFooter},
    {"metrics", "Counters of the service, for Prometheus", kMetricsFooter},
    {"reload", "Have the service read its configuration again", kReloadFooter},
}};

std::string status_text(const Json& status, const Console& console) {
  std::vector<NamedText> lines;
  lines.push_back({"state", state_text(status)});
  const Json& rig = status.at("rig");
  lines.push_back(
      {"rig", fmt::format("{} ({})", rig.at("name").get<std::string>(), rig.at("file").get<std::string>())});
  if (const std::optional<FileChange> change = change_since_read(rig)) {
    lines.push_back({"WARNING", change->what + ": what it was before is in force until eha reload"});
  }
  const DisplayUnit unit = console.unit(rig.value("units", ""));
  for (NamedText& line : rod_lines(status.value("rod", Json()), unit)) lines.push_back(std::move(line));
  if (!rig.value("moves", true) && status.at("run").is_null()) {
    lines.push_back({"", "simulated: a run begins here, and the rod is back here after it; goto and jog move it"});
  }
  const Json& lease = status.at("lease");
  lines.push_back({"lease", lease.is_null()
                                ? "none"
                                : fmt::format("held by {}, {:.0f} s left", lease.at("user").get<std::string>(),
                                              lease.at("remaining_s").get<double>())});
  if (const Json& run = status.at("run"); !run.is_null()) {
    const RunProgress progress = progress_of(status);
    lines.push_back({"run", fmt::format("{} \"{}\" of {}", run.at("entry").get<std::int64_t>(), run.value("name", ""),
                                        run.value("user", ""))});
    lines.push_back({"", is_over(status) ? std::string("over, its record is being saved")
                                         : run_line(progress, unit, std::chrono::system_clock::now())});
    lines.push_back({"loop", loop_line(progress)});
  }
  if (const Json& worker = status.at("worker"); !worker.is_null()) {
    lines.push_back({"fit", fmt::format("{} \"{}\" {}", worker.at("entry").get<std::int64_t>(),
                                        worker.value("name", ""), progress_text(worker))});
  }
  return aligned(lines);
}

ExitCode watch_status(Client& client, Console& console) {
  const StopOnSignals stop(Driver::service);
  const bool is_drawn = !console.json() && isatty(STDOUT_FILENO) == 1;
  client.call("watch", {{"rate_Hz", is_drawn ? 5.0 : 1.0}, {"samples", true}});
  RecentSamples recent;
  while (stop.count() == 0) {
    const std::optional<Json> status = client.next_event(std::chrono::seconds(1));
    if (!status) continue;
    if (console.json()) {
      console.print_content(status->dump() + "\n");
      console.flush();
      continue;
    }
    recent.add(status->at("samples"));
    console.redraw(status_text(*status, console) +
                   aligned({{"last 1 s", recent.text(console.unit(status->at("rig").value("units", "")))},
                            {"queue", fmt::format("{} waiting, {} held", status->at("waiting").get<int>(),
                                                  status->at("held").get<int>())}}));
  }
  return ExitCode::ok;
}

/// The name of a run's folder, from a name or a path; of `latest` that of the run to which the service's link leads.
std::string name_of(const std::string& run, Client& client) {
  const std::filesystem::path path = std::filesystem::path(run).lexically_normal();
  std::string name = (path.has_filename() ? path : path.parent_path()).filename().string();
  if (name != record::kLatestLink) return name;
  std::error_code ignored;
  const std::filesystem::path folder = client.call("runs").at("folder").get<std::string>();
  const std::filesystem::path target = std::filesystem::read_symlink(folder / name, ignored);
  if (target.empty()) {
    throw UsageError(fmt::format("{}: no run of the service is latest; `eha runs --socket` lists its runs", run));
  }
  return target.filename().string();
}

void print_numbers(const Json& numbers, const char* done, const char* none, const Console& console) {
  if (numbers.empty()) console.print(none);
  for (const Json& entry : numbers) console.print(fmt::format("experiment {} {}", entry.get<std::int64_t>(), done));
}

/// The sockets of other services in folders beside this one and in /run that say in a snapshot that they drive a card:
/// a stop that reaches the wrong service has to say so.
std::vector<std::filesystem::path> driven_beside(const std::filesystem::path& socket) {
  namespace fs = std::filesystem;
  std::vector<fs::path> found;
  std::error_code unknown;
  const fs::path own = fs::absolute(socket, unknown).lexically_normal();
  for (const fs::path& around :
       {fs::path(control::kDefaultSocket).parent_path().parent_path(), own.parent_path().parent_path()}) {
    fs::directory_iterator folders(around, fs::directory_options::skip_permission_denied, unknown);
    for (; !unknown && folders != fs::directory_iterator(); folders.increment(unknown)) {
      const fs::path other = folders->path() / own.filename();
      std::error_code ignored;
      if (other == own || !fs::exists(folders->path() / "safe.json", ignored) || !fs::exists(other, ignored)) continue;
      if (std::find(found.begin(), found.end(), other) == found.end()) found.push_back(other);
    }
  }
  return found;
}

/// Prints an answer, and the next step.
/// @param way  for arm: what comes before any experiment, as the move of a rod near a limit; empty: nothing
void print_answer(const ServiceCommand& command, const Json& answer, const std::string& way, const Console& console) {
  const auto next = [&](const char* what) { console.next_step(through(command.socket, what)); };
  if (command.method == "arm") {
    console.print(fmt::format("{}; you hold the lease for {:.0f} s", answer.at("state").get<std::string>(),
                              answer.at("lease_remaining_s").get<double>()));
    if (answer.contains("acknowledged")) {
      console.print(fmt::format("acknowledged: {}", answer.at("acknowledged").get<std::string>()));
    }
    for (const Json& remark : answer.value("remarks", Json::array())) console.info(remark.get<std::string>());
    for (const Json& entry : answer.value("held", Json::array())) {
      console.print(fmt::format("held: {} \"{}\", submitted {}", entry.at("entry").get<std::int64_t>(),
                                entry.value("name", ""), entry.value("submitted", "")));
    }
    // A person should look at the run of a fault before the next one.
    const std::string run = answer.value("acknowledged_run", "");
    if (!run.empty()) next(("eha runs show " + shell_word(run)).c_str());
    // Which of the rig's limits it reaches from where the rod stands is not known here.
    const std::string characterise = "eha characterise -o " + shell_word(free_name("rig-new.toml"));
    const std::string check_any = "eha check " + shell_word(an_experiment());
    if (!run.empty() && way.empty()) return;  // what is held may end like it
    if (!way.empty()) return console.next_step(way);
    next(!answer.value("held", Json::array()).empty() ? "eha queue release"
         : answer.value("characterised", true)        ? check_any.c_str()
                                                      : characterise.c_str());
  } else if (command.method == "release") {
    print_numbers(answer.at("released"), "released", "no experiment of yours is held", console);
    next("eha status");
  } else if (command.method == "hold") {
    print_numbers(answer.at("held"), "is held", "nothing was waiting", console);
    next("eha queue");
  } else if (command.method == "move") {
    console.print(fmt::format("experiment {} is number {} of {}'s", answer.at("entry").get<std::int64_t>(),
                              answer.at("position").get<std::int64_t>(), answer.value("user", "")));
    next("eha queue");
  } else if (command.method == "queue") {
    console.print(queue_table(answer.at("entries")));
  } else if (command.method == "disarm") {
    console.print("disarmed");
  } else if (command.method == "stop") {
    const std::string what = answer.at("stopped");
    const std::string of = command.socket == control::default_socket() ? "" : " at " + command.socket.string();
    console.print(what == "nothing"       ? "nothing was running" + of
                  : what == "disarmed"    ? fmt::format("nothing was running{}; the rig is disarmed", of)
                  : what == "ramping_out" ? fmt::format("ramping out{}; `{}` again makes the rig safe at once", of,
                                                        through(command.socket, "eha stop"))
                                          : fmt::format("the rig{} is made safe at once", of));
    if (what == "nothing" || what == "disarmed") {
      for (const std::filesystem::path& other : driven_beside(command.socket)) {
        console.warning(fmt::format("another rig is driven on this machine: `{}`", through(other, "eha stop")));
      }
    }
    if (what != "nothing") {
      console.print(fmt::format("{}what waited in the queue is held, and starts only after `{}` and `{}`",
                                what == "disarmed" ? "" : "afterwards the rig is disarmed; ",
                                through(command.socket, "eha arm"), through(command.socket, "eha queue release")));
      next("eha status");
    }
  } else if (command.method == "reload") {
    console.print(fmt::format("configuration read again: {}", answer.at("rig").get<std::string>()));
    next("eha arm");
  } else if (command.method == "ack") {
    console.print(fmt::format("{}: acknowledged; it may be removed when the disk budget is exceeded",
                              answer.at("run").get<std::string>()));
  } else if (command.method == "remove") {
    console.print(fmt::format("{}: removed, {:.1f} MB freed", answer.at("run").get<std::string>(),
                              answer.at("bytes").get<double>() * 1e-6));
  } else if (command.method == "cancel") {
    console.print(fmt::format("experiment {} cancelled", answer.at("entry").get<std::int64_t>()));
  }
}

/// @throws UsageError
double ruler_of(const std::string& text) {
  const std::optional<double> ruler_in = inches_of(with_decimal_point(text));
  if (ruler_in) return *ruler_in;
  throw UsageError(fmt::format("--ruler {}: expected a length with its unit, such as 75mm or 2.95in", text));
}

/// What root is asked before taking the lease from its holder, who may be at the rod.
std::string take_over_question(const Json& lease) {
  const auto text = lease.at("text").get<std::string>();
  const auto holder = lease.at("user").get<std::string>();
  return fmt::format("{}{}. {} may be at the rod. This takes the lease over and holds what waits in the queue.",
                     text.empty() ? 'T' : static_cast<char>(std::toupper(static_cast<unsigned char>(text.front()))),
                     text.empty() ? "" : text.substr(1), holder);
}

/// Calls the method, for one experiment if it accepts one.
ExitCode call_method(Client& client, const ServiceCommand& command, std::optional<std::int64_t> entry,
                     Console& console) {
  Json params = Json::object();
  if (entry) params["entry"] = *entry;
  if (command.to > 0) params["to"] = command.to;
  if (command.by != 0) params["by"] = command.by;
  if (command.ruler) params["ruler_in"] = ruler_of(*command.ruler);
  if (!command.run.empty()) params["run"] = name_of(command.run, client);
  if (command.method == "remove" && !command.yes &&
      !console.confirm(fmt::format("This deletes {} with its record and models.", params["run"].get<std::string>()))) {
    console.info("not confirmed; nothing was deleted");
    return ExitCode::interrupted;
  }
  if (command.method == "arm" && geteuid() == 0) {
    const Json lease = client.call("status").at("lease");
    if (!lease.is_null() && lease.at("uid") != 0) {
      const auto holder = lease.at("user").get<std::string>();
      if (!command.yes && !console.confirm(take_over_question(lease))) {
        console.info(fmt::format("not confirmed; the lease stays with {}", holder));
        return ExitCode::interrupted;
      }
      params["take_from"] = lease.at("uid");
    }
  }
  Json answer;
  try {
    answer = client.call(command.method, params);
  } catch (const control::ConnectionLost&) {
    throw;
  } catch (const Error& error) {
    if (command.method != "reload") throw;
    console.error(error.what());
    console.info("nothing was changed: the configuration that ehad has read before stays in force");
    return error.exit_code();
  }
  if (command.method == "metrics") {
    console.print_content(answer.at("text").get<std::string>());
    return ExitCode::ok;
  }
  if (command.method == "status") {
    answer["queue"] = client.call("queue").at("entries");
    console.print(status_text(answer, console));
    console.print(queue_table(answer["queue"]));
    const std::string way = way_to_middle(answer.at("rod"), console.unit(answer.at("rig").value("units", "")));
    const bool must_arm = answer.at("state") != "armed";
    const Json faulted_run = answer.value("faulted_run", Json());
    if (faulted_run.is_string()) {  // to be understood before anything moves
      console.next_step(through(command.socket, "eha runs show " + shell_word(faulted_run.get<std::string>())));
    } else if (!way.empty() && answer.at("run").is_null()) {
      console.next_step((must_arm ? through(command.socket, "eha arm") + " && " : "") + through(command.socket, way));
    }
  }
  std::string way;
  if (command.method == "arm") {
    const Json status = status_with_rod(client);
    const Json& rig = status.at("rig");
    warn_if_edited(rig, command.socket, console);
    warn_of_rig_file(rig, console);
    const DisplayUnit unit = console.unit(rig.value("units", ""));
    if (status.at("run").is_null()) {
      way = way_to_middle(status.at("rod"), unit);
      if (!way.empty()) way = through(command.socket, way);
      for (const NamedText& line : rod_lines(status.at("rod"), unit)) {
        if (line.name == "WARNING") console.warning(line.text);
      }
      if (const auto change =
              change_since_read(rig)) {  // no experiment is checked, and with narrower limits none begins
        way = change->first.empty()
                  ? fmt::format("{} && {} && {}", through(command.socket, "eha disarm"),
                                through(command.socket, "eha reload"), through(command.socket, "eha arm"))
                  : "eha check " + shell_word(rig.at("file").get<std::string>());
      }
    }
  }
  print_answer(command, answer, way, console);
  console.print_json(answer);
  return ExitCode::ok;
}

}  // namespace

ExitCode execute(const ServiceCommand& command, Console& console) {
  Client client(command.socket);
  if (command.watch) return watch_status(client, console);
  if (command.entries.size() < 2) {
    return call_method(client, command, command.entries.empty() ? std::nullopt : std::optional(command.entries.front()),
                       console);
  }
  console.keep_documents();
  ExitCode code = ExitCode::ok;
  for (const std::int64_t entry : command.entries) {
    try {
      call_method(client, command, entry, console);
    } catch (const control::ConnectionLost&) {
      throw;
    } catch (const Error& error) {  // one that began meanwhile must not keep the others
      console.error(error.what());
      if (code == ExitCode::ok) code = error.exit_code();
    }
  }
  const Json documents = console.taken_documents();
  console.print_json({{"answers", documents}});
  console.next_step(through(command.socket, "eha queue"));
  return code;
}

namespace {

/// Refuses what is no number of an experiment.
CLI::Validator entry_number() {
  const auto check = [](const std::string& text) -> std::string {
    std::int64_t number = 0;
    if (CLI::detail::lexical_cast(text, number) && number >= 1 && number <= std::int64_t{1} << 53) return {};
    return fmt::format(
        "\"{}\": expected the number of an experiment, such as 7, as the first column of `eha queue` lists them", text);
  };
  return CLI::Validator(check, "");
}

/// Reads the target of `eha queue move`. @returns its error, or nothing
std::string take_place(const std::string& where, ServiceCommand& service) {
  if (where == "up" || where == "down") {
    service.by = where == "up" ? -1 : 1;
  } else if (where == "first" || where == "last") {
    service.to = where == "first" ? 1 : kLastPosition;
  } else if (std::int64_t position = 0; CLI::detail::lexical_cast(where, position) && position >= 1) {
    service.to = std::min(position, kLastPosition);
  } else {
    return "expected up, down, first, last or a position from 1, got \"" + where + "\"";
  }
  return {};
}

void add_queue(CLI::App& app, ParsedLine& line) {
  CLI::App* queue = app.add_subcommand("queue", "List the queue, or hold, release, move and cancel experiments");
  queue->footer(kQueueFooter);
  queue->require_subcommand(0, 1);
  const auto shared = std::make_shared<ServiceCommand>();  // --socket may stand before and after the subcommand
  ServiceCommand& service = *shared;
  add_socket_option(*queue, service.socket);
  queue->callback([shared, queue, &line] {
    const std::vector<CLI::App*> chosen = queue->get_subcommands();
    const std::string name = chosen.empty() ? "list" : chosen.front()->get_name();
    shared->method = name == "list" ? "queue" : name;
    line.command = Request<ServiceCommand>{*shared};
  });
  const auto add = [&](const char* name, const char* help) {
    CLI::App* sub = queue->add_subcommand(name, help);
    add_socket_option(*sub, service.socket);
    return sub;
  };
  add("list", "List waiting, held and running experiments, and the last finished ones");
  add_entries(*add("hold", "Keep waiting experiments from starting"), service,
              "Numbers in the queue (default: all your waiting ones)");
  add_entries(*add("release", "Let held experiments of yours start; the rig must be armed"), service,
              "Numbers in the queue (default: all your held ones)");
  add_entries(*add("cancel", "Remove waiting or held experiments"), service, "Numbers in the queue")->required();
  CLI::App* move = add("move", "Change the order in which your experiments start");
  move->footer(kMoveFooter);
  move->add_option_function<std::int64_t>(
          "number", [&service](const std::int64_t& number) { service.entries = {number}; }, "Number in the queue")
      ->required()
      ->type_name("NUMBER")
      ->check(entry_number());
  move->add_option_function<std::string>(
          "where",
          [&service](const std::string& where) {
            if (const std::string wrong = take_place(where, service); !wrong.empty()) {
              throw CLI::ValidationError("where", wrong);
            }
          },
          "up, down, first, last, or a position among your queued experiments, from 1")
      ->required()
      ->type_name("up|down|first|last|POSITION");
}

}  // namespace

CLI::Option* add_socket_option(CLI::App& app, std::filesystem::path& socket) {
  return app.add_option("--socket", socket, kSocketHelp)->type_name("PATH");
}

CLI::Option* add_socket_option(CLI::App& app, std::optional<std::filesystem::path>& socket) {
  return app.add_option("--socket", socket, kSocketHelp)->type_name("PATH");
}

CLI::Option* add_entries(CLI::App& app, ServiceCommand& service, const char* help) {
  return app.add_option("number", service.entries, help)->type_name("NUMBER")->check(entry_number());
}

void add_service_commands(CLI::App& app, ParsedLine& line) {
  for (const Verb& verb : kVerbs) {
    CLI::App* sub = app.add_subcommand(verb.name, verb.help);
    sub->footer(verb.footer);
    auto& service = options_of<ServiceCommand>(*sub, line, {.method = verb.name});
    add_socket_option(*sub, service.socket);
    if (std::string(verb.name) == "arm") {
      sub->add_option("--ruler", service.ruler,
                      "Where a ruler shows the rod, such as 75mm or 2.95in; needed after the sensor has slipped")
          ->type_name("LENGTH");
      sub->add_flag("--yes", service.yes, "As root: take the lease from its holder without asking");
    }
    if (std::string(verb.name) == "status") sub->add_flag("--watch", service.watch, "Repeat until Ctrl-C");
  }
  add_queue(app, line);
}

}  // namespace eha::cli
