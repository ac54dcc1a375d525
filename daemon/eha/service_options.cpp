// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/service_options.hpp"

#include <array>
#include <cstdint>

namespace eha::cli {
namespace {

constexpr const char* kSocketHelp = "Where ehad listens (default $EHA_SOCKET, otherwise /run/ehad/ehad.sock)";

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
Lists the submitted experiments. A held one starts only after its release. An experiment is held if you submitted it
while you did not have the armed rig, or if it waited at a fault, a stop, a disarming or a restart.

Examples:
  eha queue
  eha arm && eha queue release 7)";

struct Verb {
  const char* name;
  const char* help;
  const char* footer;
};

constexpr std::array<Verb, 6> kVerbs{{
    {"status", "What the service and its rig are doing", kStatusFooter},
    {"arm", "Acknowledge, arm the rig and take the lease", kArmFooter},
    {"disarm", "Disarm the rig and return the lease", kDisarmFooter},
    {"stop", "Stop the current run; anyone may", kStopFooter},
    {"metrics", "Counters of the service, for Prometheus", kMetricsFooter},
    {"reload", "Have the service read its configuration again", kReloadFooter},
}};

}  // namespace

CLI::Option* add_socket_option(CLI::App& app, std::filesystem::path& socket) {
  return app.add_option("--socket", socket, kSocketHelp)->type_name("PATH");
}

CLI::Option* add_socket_option(CLI::App& app, std::optional<std::filesystem::path>& socket) {
  return app.add_option("--socket", socket, kSocketHelp)->type_name("PATH");
}

void add_read(CLI::App& app, ReadCommand& read) {
  CLI::App* sub = app.add_subcommand("read", "Where the rod is, and what the sensor and the lines say; moves nothing");
  sub->footer(kReadFooter);
  CLI::Option* local = sub->add_flag("--local", read.local, "Read the rig in this process instead of through ehad");
  add_socket_option(*sub, read.socket)->excludes(local);
  sub->add_option("--rig", read.rig_file, "Rig file (TOML); with --local only")->type_name("RIG")->needs(local);
  sub->add_flag("--watch", read.watch, "Repeat until Ctrl-C");
}

void add_service_commands(CLI::App& app, ServiceCommand& service) {
  for (const Verb& verb : kVerbs) {
    CLI::App* sub = app.add_subcommand(verb.name, verb.help);
    sub->footer(verb.footer);
    add_socket_option(*sub, service.socket);
    if (std::string(verb.name) == "status") sub->add_flag("--watch", service.watch, "Repeat until Ctrl-C");
    sub->callback([&service, name = verb.name] { service.method = name; });
  }
  CLI::App* queue = app.add_subcommand("queue", "List the queue, or release held experiments");
  queue->footer(kQueueFooter);
  queue->require_subcommand(0, 1);
  add_socket_option(*queue, service.socket);
  queue->callback([&service, queue] { service.method = queue->got_subcommand("release") ? "release" : "queue"; });
  CLI::App* list = queue->add_subcommand("list", "List what waits, is held or runs, and the last that are over");
  add_socket_option(*list, service.socket);
  CLI::App* release = queue->add_subcommand("release", "Let held experiments of yours start; the rig must be armed");
  release->add_option("number", service.entry, "Number in the queue (default: all of yours)")
      ->type_name("NUMBER")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1} << 53).description(""));
  add_socket_option(*release, service.socket);
}

}  // namespace eha::cli
