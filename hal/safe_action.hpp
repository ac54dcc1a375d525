// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace eha::hal {

/// Makes one rig safe from outside the process that has it open, or had it open when it died.
struct SafeAction {
  std::string device;  ///< "/dev/comedi0", for messages
  /// Switches the hydraulics off and writes the safe voltage, trying again for at most the given time, whatever the
  /// cause. Returns what was done: "output at 0 V, hydraulics off".
  /// Throws DeviceError (not safe) or PermissionError.
  std::function<std::string(std::chrono::milliseconds)> make_safe;
  /// Switches the hydraulics off and nothing else, in one try, also while the driving process holds the device. Returns
  /// whether they are off. Throws nothing. Empty for a rig without an enable line.
  std::function<bool()> switch_off = {};
  /// Opens the device now and keeps it open, so that a device node that is gone later, or a process out of descriptors,
  /// does not keep the hydraulics on.
  /// Returns whether it is open. Throws nothing.
  std::function<bool()> keep_open = {};
};

}  // namespace eha::hal
