// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/drive_options.hpp"

#include <CLI/CLI.hpp>

#include "daemon/eha/service_command.hpp"

namespace eha::cli {

CLI::Option* add_drive_options(CLI::App& command, DriveOptions& drive) {
  CLI::Option* local =
      command.add_flag("--local", drive.local, "Drive the rig in this process instead of through ehad");
  add_socket_option(command, drive.socket)->excludes(local);
  command.add_option("--rig", drive.rig_file, "Rig file (TOML); with --local only")->type_name("RIG")->needs(local);
  command.add_flag("--fast", drive.fast, "Virtual time: as fast as this machine computes; simulated rigs only");
  command.add_option("-o,--output", drive.output, "Parent of the run folder (default runs); with --local only")
      ->type_name("DIR")
      ->needs(local);
  command.add_flag("--yes", drive.yes, "Move a real actuator without asking");
  command
      .add_flag("--allow-non-realtime", drive.allow_non_realtime,
                "Run even without real-time privileges, for test benches; with --local only")
      ->needs(local);
  return local;
}

}  // namespace eha::cli
