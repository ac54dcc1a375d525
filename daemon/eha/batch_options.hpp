// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CLI/CLI.hpp>

#include "daemon/eha/commands.hpp"

namespace eha::cli {

/// The commands under `eha batch`.
struct BatchCommands {
  BatchCommand batch;
  BatchMergeCommand merge;
};

/// `eha batch SOURCE...` and `eha batch merge DIR...`. Arguments after `--` are not parsed by `app`.
void add_batch(CLI::App& app, BatchCommands& commands);

}  // namespace eha::cli
