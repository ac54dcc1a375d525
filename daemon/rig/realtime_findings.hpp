// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/rig_config.hpp"
#include "daemon/rig/arming.hpp"

namespace eha {

/// Judges [realtime] of a rig that moves a machine: a tick, a stall or a number of late ticks beyond which no check
/// acts in time, and a priority that the guard could not preempt.
void judge_realtime(const config::RigConfig& rig, ArmingFindings& findings);

}  // namespace eha
