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

/// What stands at a rig's device node, and what would drive a card there.
struct CardFinding {
  std::optional<hal::CardDescription> card;  ///< none: it cannot be opened
  ExitCode code = ExitCode::ok;              ///< why not: device_unavailable or permission
  std::string error;                         ///< why not, in words
  bool on_bus = false;                       ///< PCI bus holds the board, for boards whose PCI id is known
  ModuleSupport module = ModuleSupport::unknown;
};

/// Opens the device, reads what it says of itself and closes it again; changes nothing on it.
/// @param root     "/", or a folder laid out like it: for /sys and /lib/modules
/// @param release  of the running kernel, "6.1.0-25-rt-amd64"
[[nodiscard]] CardFinding find_card(const hal::ComediOptions& options, const std::filesystem::path& root,
                                    const std::string& release);

/// Judges device, driver and board against the rig file.
[[nodiscard]] std::vector<Check> check_card(const hal::ComediOptions& options, const CardFinding& finding);

/// Judges the lines that no software replaces: emergency stop, enable, heartbeat. A rig file that says nothing about
/// one of them is not read at all; one that says "none" is warned about.
[[nodiscard]] std::vector<Check> check_lines(const hal::ComediOptions& options);

}  // namespace eha::doctor
