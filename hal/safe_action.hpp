// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace eha::hal {

/// Makes one rig safe after the process that had it open has died.
struct SafeAction {
  std::string device;  ///< "/dev/comedi0", for messages
  /// Switches the hydraulics off and writes the safe voltage, trying again for at most the given time while the device
  /// is busy. Returns what was done: "output at 0 V, hydraulics off".
  /// Throws DeviceError (not safe) or PermissionError.
  std::function<std::string(std::chrono::milliseconds)> make_safe;
};

}  // namespace eha::hal
