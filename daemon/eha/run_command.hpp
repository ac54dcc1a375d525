// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/eha/drive_options.hpp"

namespace eha::cli {

class Console;

struct RunCommand : DriveOptions {
  std::string experiment_file = {};
  std::vector<std::string> further_files = {};  ///< played after the first one, in order
  std::optional<std::string> text = {};         ///< of the experiment; none: experiment_file is read
  bool detach = false;                          ///< queue without waiting
  bool accept_travel_risk = false;              ///< play even if the rehearsal refuses
  std::optional<std::string> ruler = {};        ///< reading of a ruler at the rod, for [characterise]; none: asked for
  std::optional<std::filesystem::path> new_rig_file = {};  ///< to write with the numbers of a valve sheet
  std::optional<double> simulated_tick_s = {};  ///< of a simulated rig in this process, instead of its file's
};

[[nodiscard]] ExitCode execute(const RunCommand& command, Console& console);

}  // namespace eha::cli
