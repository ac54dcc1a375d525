// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "config/rig_config.hpp"
#include "daemon/acquisition/realtime.hpp"
#include "daemon/doctor/check.hpp"
#include "daemon/doctor/privileges.hpp"
#include "daemon/doctor/system_files.hpp"

namespace eha::doctor {

/// The machine that the tick loop runs on.
struct Machine {
  acquisition::KernelFacts kernel;
  SystemFiles files;
  Privileges privileges;
};

/// Checks whether the machine can keep the rig's ticks: kernel, scheduling, limits, CPUs, sleep, clock. An unmet
/// requirement without which the loop refuses to run is a failure for a rig that moves a machine and a warning for a
/// simulated one.
[[nodiscard]] std::vector<Check> check_machine(const Machine& machine, const config::RealtimeOptions& realtime,
                                               Stakes stakes);

}  // namespace eha::doctor
