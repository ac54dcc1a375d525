// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

namespace eha::cli {

class Console;
struct DriveOptions;

/// Checks, before the first valve measurement on a rig that moves a machine, that the sensor agrees with a ruler. Asks
/// for the reading on a terminal. Does nothing if the rig file has [following].
/// @param ruler  "2.95in"; none: asked for   @returns the reading [in]; none: none is needed
/// @throws UsageError   no reading, and no terminal to ask on   @throws ConfigError  they differ
/// @throws DeviceError  the rod cannot be read
std::optional<double> agreed_ruler(const DriveOptions& command, const std::optional<std::string>& ruler,
                                   const Console& console);

}  // namespace eha::cli
