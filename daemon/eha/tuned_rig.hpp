// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "config/rig_config.hpp"
#include "hal/sim/sim_options.hpp"

// The rig that a controller is made for.

namespace eha::cli {

/// Reads a rig file, or the one of a run. @throws DataError  a run without one; as config::load_rig()
[[nodiscard]] config::RigConfig rig_of(const std::filesystem::path& file_or_run);

/// Whether two rig files are of one rig; their limits and [following] may differ.
[[nodiscard]] bool is_one_rig(const config::RigConfig& a, const config::RigConfig& b);

/// The simulated rig of a rig file. @throws UsageError  it drives a machine; as config::load_rig()
[[nodiscard]] hal::SimOptions twin_of(const std::string& file);

/// The rig file of a run, where it still is; none in a damaged run.
[[nodiscard]] std::optional<std::string> rig_file_of(const std::filesystem::path& run);

/// The name of a rig file, or of a run's, for --rig, as rig_name().
[[nodiscard]] std::string rig_name_of(const std::filesystem::path& file_or_run);

}  // namespace eha::cli
