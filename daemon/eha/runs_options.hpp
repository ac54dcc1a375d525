// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>

#include "daemon/eha/commands.hpp"

namespace eha::cli {

/// The commands under `eha runs`.
struct RunsCommands {
  RunsListCommand list;
  RunsShowCommand show;
  RunsRecoverCommand recover;
  ServiceCommand cancel{.method = "cancel"};
  ServiceCommand ack{.method = "ack"};
  ServiceCommand remove{.method = "remove"};
};

/// `eha runs list|show|recover|cancel|ack|remove`.
void add_runs(CLI::App& app, RunsCommands& runs);

}  // namespace eha::cli
