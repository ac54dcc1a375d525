// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "config/rig_config.hpp"

namespace eha::cli {

/// Rig file of a local run without --rig: /etc/ehad/rig.toml, else the simulated rig installed with the program, else
/// the one of the source tree that the program was built in. None when there is none of these.
[[nodiscard]] std::optional<std::filesystem::path> default_rig_file();

/// Reads the named rig file or the default one.
/// @throws UsageError  neither is there; ConfigError, PermissionError as config::load_rig
[[nodiscard]] config::RigConfig load_rig_or_default(const std::optional<std::string>& rig_file);

}  // namespace eha::cli
