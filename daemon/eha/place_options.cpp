// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/place_options.hpp"

#include "daemon/eha/drive_options.hpp"

namespace eha::cli {
namespace {

constexpr const char* kGotoFooter = R"(
Moves the rod slowly (at most 0.3 in/s) to a place within the travel limits, and ends once it has been within 0.02 in of it
for 0.5 s; then the rig is safe, with the hydraulics off. It is a run like any other: you must have armed the rig, a real
actuator is moved only after your confirmation, every limit of the rig file holds, Ctrl-C ramps out, and the way there is
recorded. Null and dead band of the valve are compensated; [following] of the rig file makes it quicker.
Code 11 when a limit or the time-out (120 s) ends it; the message gives the cause.

Examples:
  eha arm && eha goto 2.95in
  eha goto 75mm --local --fast)";

constexpr const char* kJogFooter = R"(
As eha goto, to a place a little above (+) or below (-) the present one. Moves between runs only.

Examples:
  eha jog +0.2in
  eha jog -5mm)";

void add_placing(CLI::App& app, const char* name, const char* help, const char* footer, const char* what,
                 PlaceCommand& place) {
  CLI::App* sub = app.add_subcommand(name, help);
  sub->footer(footer);
  sub->add_option("where", place.where, what)->required()->type_name("LENGTH");
  add_drive_options(*sub, place);
}

}  // namespace

void add_place_commands(CLI::App& app, PlaceCommands& commands) {
  commands.jog.is_relative = true;
  add_placing(app, "goto", "Move the rod slowly to a place", kGotoFooter, "The place, such as 2.95in or 75mm",
              commands.go_to);
  add_placing(app, "jog", "Move the rod a little", kJogFooter, "How far, such as +0.2in or -5mm", commands.jog);
}

}  // namespace eha::cli
