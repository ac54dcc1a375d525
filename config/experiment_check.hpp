// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/experiment_config.hpp"
#include "config/fault_list.hpp"

namespace eha::config {

/// Adds every conflict of an experiment with a rig, as check_against() lists them, to the faults found so far. What
/// depends on a key that already has a fault is left out.
void add_conflicts(const ExperimentConfig& experiment, const PositionMap& positions, const RigConfig& rig,
                   FaultList& faults);

}  // namespace eha::config
