// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/doctor/check.hpp"
#include "daemon/doctor/system_files.hpp"
#include "hal/comedi/card_description.hpp"
#include "hal/comedi/comedi_options.hpp"

namespace eha::doctor {

/// The device of a rig file and its kernel driver, as found.
struct CardFinding {
  std::optional<hal::CardDescription> card;  ///< none: it cannot be opened
  ExitCode code = ExitCode::ok;              ///< of the failed open: device_unavailable or permission
  std::string error;                         ///< its message
  bool on_bus = false;                       ///< PCI bus holds the board, for boards whose PCI id is known
  ModuleSupport module = ModuleSupport::unknown;
};

/// Opens the device, reads its description and closes it; changes nothing on it.
/// @param root     "/", or a folder laid out like it: for /sys and /lib/modules
/// @param release  of the running kernel, "6.1.0-25-rt-amd64"
[[nodiscard]] CardFinding find_card(const hal::ComediOptions& options, const std::filesystem::path& root,
                                    const std::string& release);

/// Checks device, driver and board against the rig file.
[[nodiscard]] std::vector<Check> check_card(const hal::ComediOptions& options, const CardFinding& finding);

/// Checks the emergency stop, enable and heartbeat lines, which software cannot replace. A line configured as "none" is
/// a warning; a rig file without one of them is refused before this.
[[nodiscard]] std::vector<Check> check_lines(const hal::ComediOptions& options);

}  // namespace eha::doctor
