// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/rig_config.hpp"
#include "core/error.hpp"
#include "daemon/play/play.hpp"

namespace eha::config {
struct ExperimentConfig;
}  // namespace eha::config

namespace eha::cli {

class Console;
struct RunCommand;

/// A run that this process has played.
struct Acquired {
  play::FinishedRun run;
  bool was_guarded = true;   ///< the guard lived to the end
  bool was_stopped = false;  ///< by a signal, which may have come after the last tick
};

/// Reports what came of it: fits and judges an experiment, shows the place, the valve sheet or the trial of the other
/// kinds; of a run that did not complete or lost its guard the cause, and the kept record. Cost: of an experiment that
/// of its fits, seconds. @throws Error  it cannot be computed; the record is kept
[[nodiscard]] ExitCode conclude(const RunCommand& command, const config::RigConfig& rig,
                                const config::ExperimentConfig& experiment, const Acquired& acquired, Console& console);

}  // namespace eha::cli
