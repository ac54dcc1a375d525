// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <comedilib.h>

#include <string>

#include "hal/comedi/card_description.hpp"
#include "hal/rig.hpp"

namespace eha::hal {

/// An open comedi device. The descriptor is close-on-exec: a child that inherited it would keep the locks, and another
/// process could not write the safe voltage.
class ComediDevice {
 public:
  /// @throws DeviceError, PermissionError
  explicit ComediDevice(const std::string& path);
  ComediDevice(const ComediDevice&) = delete;
  ComediDevice& operator=(const ComediDevice&) = delete;
  ~ComediDevice();

  [[nodiscard]] comedi_t* get() const noexcept { return handle_; }
  [[nodiscard]] CardDescription describe() const;

 private:
  comedi_t* handle_ = nullptr;
};

/// Returns the status of this thread's last failed call. Real-time safe.
[[nodiscard]] RigStatus last_comedi_status() noexcept;

/// Returns the message of this thread's last failed call.
[[nodiscard]] std::string last_comedi_error();

/// Sets one digital line. Real-time and signal safe: uses nothing but its stack.
[[nodiscard]] RigStatus write_line(comedi_t* device, unsigned subdevice, unsigned channel, unsigned level) noexcept;

/// Writes one converter code. Real-time and signal safe: uses nothing but its stack.
[[nodiscard]] RigStatus write_code(comedi_t* device, unsigned subdevice, unsigned chanspec, lsampl_t code) noexcept;

}  // namespace eha::hal
