// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace eha::hal {

/// Makes one rig safe from another process than the one that has it open, or had it open when it died.
struct SafeAction {
  std::string device;  ///< "/dev/comedi0", for messages
  /// Switches the hydraulics off and writes the safe voltage; retries for at most the given time after any failure.
  /// Returns the result: "output at 0 V, hydraulics off".
  /// Throws DeviceError (not safe) or PermissionError.
  std::function<std::string(std::chrono::milliseconds)> make_safe;
  /// Only switches the hydraulics off, in one try, also while the driving process holds the device. Returns whether
  /// they are off. Throws nothing. Empty for a rig without an enable line.
  std::function<bool()> switch_off = {};
  /// Opens the device now and keeps it open, so that the hydraulics can still be switched off if the device node
  /// disappears or the process runs out of descriptors.
  /// Returns whether it is open. Throws nothing.
  std::function<bool()> keep_open = {};
};

}  // namespace eha::hal
