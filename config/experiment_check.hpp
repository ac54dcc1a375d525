// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "config/experiment_config.hpp"
#include "config/issue_list.hpp"

namespace eha::config {

/// Builds the experiment's table of volts and adds every conflict with the rig, as prepare() lists them, to the issues
/// found so far. Checks that depend on a key with an issue are left out.
/// @returns one repetition [V]; empty if it could not be built
[[nodiscard]] Eigen::VectorXd check_table(const ExperimentConfig& experiment, const PositionMap& positions,
                                          const RigConfig& rig, IssueList& issues);

}  // namespace eha::config
