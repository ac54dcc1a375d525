// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>

#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"

namespace eha::record {

/// Writes a configuration with its defaults filled in, then the file's text. Leaves out file names, because they depend
/// on the folder in which the program was started.
[[nodiscard]] nlohmann::ordered_json to_json(const config::RigConfig& rig);
[[nodiscard]] nlohmann::ordered_json to_json(const config::ExperimentConfig& experiment);

}  // namespace eha::record
