// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"

namespace eha {

/// Returns the question that the user must confirm before the experiment is played on the rig; none if no machine
/// moves.
[[nodiscard]] std::optional<std::string> confirmation_text(const config::RigConfig& rig,
                                                           const config::ExperimentConfig& experiment);

}  // namespace eha
