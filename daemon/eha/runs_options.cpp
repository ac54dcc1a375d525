// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/runs_options.hpp"

#include "daemon/eha/service_options.hpp"

namespace eha::cli {

void add_runs(CLI::App& app, RunsCommands& runs) {
  CLI::App* sub = app.add_subcommand("runs", "List, show, recover, cancel, acknowledge or remove runs");
  sub->fallthrough();
  sub->require_subcommand(1);
  sub->footer("\nExamples:\n  eha runs list\n  eha runs show runs/latest\n  eha runs recover runs");
  CLI::App* list = sub->add_subcommand("list", "One line for each run, oldest first");
  list->add_option("folder", runs.list.folder, "Folder of run folders (default runs, else the service's)")
      ->type_name("DIR");
  add_socket_option(*list, runs.list.socket);
  CLI::App* show = sub->add_subcommand("show", "Show outcome, models and verdicts of a run");
  show->add_option("run", runs.show.run, "Run folder")->required()->type_name("RUN");
  CLI::App* recover = sub->add_subcommand("recover", "Complete runs whose process died, from their journals");
  recover->add_option("target", runs.recover.target, "Run folder, or folder of run folders")
      ->required()
      ->type_name("RUN|DIR");
  CLI::App* cancel = sub->add_subcommand("cancel", "Remove a waiting or held experiment from the service's queue");
  add_entries(*cancel, runs.cancel, "Numbers in the queue, see eha queue")->required();
  add_socket_option(*cancel, runs.cancel.socket);
  CLI::App* ack = sub->add_subcommand("ack", "Acknowledge the incident of a run; retention may then remove the run");
  ack->add_option("run", runs.ack.run, "Run folder, or its name")->required()->type_name("RUN");
  add_socket_option(*ack, runs.ack.socket);
  CLI::App* remove = sub->add_subcommand("remove", "Delete a run of the service, its record and models");
  remove->add_option("run", runs.remove.run, "Run folder, or its name")->required()->type_name("RUN");
  remove->add_flag("--yes", runs.remove.yes, "Without asking");
  add_socket_option(*remove, runs.remove.socket);
}

}  // namespace eha::cli
