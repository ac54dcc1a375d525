// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/run_command.hpp"

#include <string>
#include <vector>

#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/run_local.hpp"
#include "daemon/eha/run_service.hpp"

namespace eha::cli {
namespace {

constexpr const char* kRunFooter = R"(
Plays the experiment's excitation [V] on the rig every tick, records the displacement, fits the experiment's
models and judges them. The run folder OUTPUT/<UTC time>-<name> holds run.json, raw.ehalog, raw.h5, data_40ms.csv,
frequency_response.csv, fit.csv, report.html and models/*.json; a rejected model goes to models/rejected. OUTPUT/latest
points to the last run with an accepted model.
One Ctrl-C ramps the command down and keeps the record; a second one makes the rig safe at once.
Without --local the service ehad does the same with its own rig file and folder, when the experiment is next in its
queue and you hold the lease (`eha arm`). Ctrl-C stops the run; losing the connection does not.
All experiments are checked before the first one is queued or played; a fault in one refuses all.
During a run a terminal shows the time left [s], the rod between its limits, the command [V], late ticks and the predicted
margin to the travel limits; elsewhere a line appears every 30 s.

Examples:
  eha arm && eha run config/experiments/paper.toml
  eha run slow.toml fast.toml --detach
  eha run config/experiments/paper.toml --local --fast
  eha run sweep.toml --local --rig rig.toml --output /data/runs)";

}  // namespace

ExitCode execute(const RunCommand& command, Console& console) {
  console.set_rig(access_of(command));
  return command.local ? run_in_this_process(command, console) : run_through_service(command, console);
}

void add_run(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("run", "Play an experiment on a rig, record it, fit and judge its models");
  sub->footer(kRunFooter);
  auto& run = options_of<RunCommand>(*sub, line);
  sub->add_option_function<std::vector<std::string>>(
         "experiment",
         [&run](const std::vector<std::string>& files) {
           run.experiment_file = files.front();
           run.further_files.assign(files.begin() + 1, files.end());
         },
         "Experiment files (TOML), played in this order")
      ->required()
      ->type_name("EXPERIMENT");
  CLI::Option* local = add_drive_options(*sub, run);
  sub->add_flag("--detach", run.detach, "Queue the experiments and leave; not with --local")->excludes(local);
  sub->add_flag("--accept-travel-risk", run.accept_travel_risk,
                "Play even if half of the rehearsed rods reach a limit");
  sub->add_option("--ruler", run.ruler,
                  "Where a ruler shows the rod, such as 2.95in or 75mm; for [characterise] without [following]")
      ->type_name("LENGTH");
}

}  // namespace eha::cli
