// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace eha {

/// Voltages of a CSV file that a configuration file names.
struct VoltsFile {
  std::string name;              ///< as written in the configuration file
  std::vector<double> volts_V;   ///< one a tick [V]; empty if the file was not read
  std::optional<double> step_s;  ///< spacing of the file's column time_s [s], if it has one
};

}  // namespace eha
