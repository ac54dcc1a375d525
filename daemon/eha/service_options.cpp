// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/service_options.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace eha::cli {
namespace {

constexpr const char* kSocketHelp = "Where ehad listens (default $EHA_SOCKET, otherwise /run/ehad/ehad.sock)";

constexpr std::int64_t kLastPosition = 1000;  // more than the queue holds

constexpr const char* kStatusFooter = R"(
Shows the state of the rig, the rod (in, V) on a bar between its limits, the holder of the lease and its remaining time
[s], the current run (s, V, latency in us) and the queue. --watch redraws it until Ctrl-C.

Examples:
  eha status
  eha status --watch)";

constexpr const char* kReadFooter = R"(
Shows where the rod is [in], on a bar between its limits ('=': beyond 80 % of the way to a limit), the sensor's voltage
[V], code and noise [in], the digital lines and whether the rig is armed. Moves nothing. Asks the service; where none
listens, or with --local, it reads the rig of --rig itself. --watch redraws it until Ctrl-C.

Examples:
  eha read
  eha read --watch --units mm
  eha read --local --rig rig.toml)";

constexpr const char* kArmFooter = R"(
Acknowledges earlier faults and arms the rig. For 10 minutes after your last command or run only you may run
experiments and disarm. Arming starts nothing: it lists the held experiments, see eha queue release.

Examples:
  eha arm
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
Reads rig.toml and ehad.toml again. Refused while the rig is armed; a file with faults changes nothing.

Example:
  eha reload)";

constexpr const char* kQueueFooter = R"(
Lists the submitted experiments; those of one user start in the order listed. A held one starts only after its release.
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

CLI::Validator entry_number() { return CLI::Range(std::int64_t{1}, std::int64_t{1} << 53).description(""); }

/// Takes where `eha queue move` moves to. @returns what is wrong with it, or nothing
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

void add_queue(CLI::App& app, ServiceCommand& service) {
  CLI::App* queue = app.add_subcommand("queue", "List the queue, or hold, release, move and cancel experiments");
  queue->footer(kQueueFooter);
  queue->require_subcommand(0, 1);
  add_socket_option(*queue, service.socket);
  queue->callback([&service, queue] {
    const std::vector<CLI::App*> chosen = queue->get_subcommands();
    const std::string name = chosen.empty() ? "list" : chosen.front()->get_name();
    service.method = name == "list" ? "queue" : name;
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

void add_read(CLI::App& app, ReadCommand& read) {
  CLI::App* sub = app.add_subcommand("read", "Show the rod, its sensor and the digital lines; moves nothing");
  sub->footer(kReadFooter);
  CLI::Option* local = sub->add_flag("--local", read.local, "Read the rig in this process instead of through ehad");
  add_socket_option(*sub, read.socket)->excludes(local);
  sub->add_option("--rig", read.rig_file, "Rig file (TOML); with --local only")->type_name("RIG")->needs(local);
  sub->add_flag("--watch", read.watch, "Repeat until Ctrl-C");
}

CLI::Option* add_entries(CLI::App& app, ServiceCommand& service, const char* help) {
  return app.add_option("number", service.entries, help)->type_name("NUMBER")->check(entry_number());
}

void add_service_commands(CLI::App& app, ServiceCommand& service) {
  for (const Verb& verb : kVerbs) {
    CLI::App* sub = app.add_subcommand(verb.name, verb.help);
    sub->footer(verb.footer);
    add_socket_option(*sub, service.socket);
    if (std::string(verb.name) == "status") sub->add_flag("--watch", service.watch, "Repeat until Ctrl-C");
    sub->callback([&service, name = verb.name] { service.method = name; });
  }
  add_queue(app, service);
}

}  // namespace eha::cli
