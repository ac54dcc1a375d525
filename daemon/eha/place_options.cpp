// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/place_options.hpp"

#include "daemon/eha/service_options.hpp"

namespace eha::cli {
namespace {

constexpr const char* kGotoFooter = R"(
Moves the rod slowly (at most 0.3 in/s) to a place within the travel limits, and ends once it has been within 0.02 in of it
for 0.5 s; then the rig is safe, with the hydraulics off. It is a run like any other: you must have armed the rig, a real
actuator is moved only after your confirmation, every limit of the rig file holds, Ctrl-C ramps out, and the way there is
recorded. Null and dead band of the valve are compensated; [following] of the rig file makes it quicker.
Code 11 when a limit or the time-out (120 s) ends it: the message says what was in the way.

Examples:
  eha arm && eha goto 2.95in
  eha goto 75mm --local --fast)";

constexpr const char* kJogFooter = R"(
As eha goto, to a place a little above (+) or below (-) where the rod is now. Moves between runs only.

Examples:
  eha jog +0.2in
  eha jog -5mm)";

void add_placing(CLI::App& app, const char* name, const char* help, const char* footer, const char* what,
                 PlaceCommand& place) {
  CLI::App* sub = app.add_subcommand(name, help);
  sub->footer(footer);
  sub->add_option("where", place.where, what)->required()->type_name("LENGTH");
  CLI::Option* local = sub->add_flag("--local", place.local, "Move the rig in this process instead of through ehad");
  add_socket_option(*sub, place.socket)->excludes(local);
  sub->add_option("--rig", place.rig_file, "Rig file (TOML); with --local only")->type_name("RIG")->needs(local);
  sub->add_flag("--fast", place.fast, "Virtual time: as fast as this machine computes; simulated rigs only");
  sub->add_option("--output", place.output, "Folder that the run folder is put into (default runs); with --local only")
      ->type_name("DIR")
      ->needs(local);
  sub->add_flag("--yes", place.yes, "Move a real actuator without asking");
  sub->add_flag("--allow-non-realtime", place.allow_non_realtime,
                "Move without real-time privileges too, for test benches; with --local only")
      ->needs(local);
}

}  // namespace

void add_place_commands(CLI::App& app, PlaceCommands& commands) {
  add_placing(app, "goto", "Move the rod slowly to a place", kGotoFooter, "The place, such as 2.95in or 75mm",
              commands.go_to);
  add_placing(app, "jog", "Move the rod a little", kJogFooter, "How far, such as +0.2in or -5mm", commands.jog);
}

}  // namespace eha::cli
