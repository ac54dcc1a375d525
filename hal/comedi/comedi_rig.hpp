// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "hal/comedi/card_description.hpp"
#include "hal/comedi/comedi_options.hpp"
#include "hal/rig.hpp"

namespace eha::hal {

/// Opens a card through libcomedi, locks its inputs and the analogue output (not the output lines, so that the guard
/// can switch the hydraulics off) and leaves it safe: enable line off, then the output at the safe voltage (second,
/// because the first write to a range may pass through its lower end).
///
/// read() samples the feedback (select, settle, convert) and the digital inputs in one instruction list; command()
/// writes the output and the toggled heartbeat in another. One kernel call may take up to a second if the card does not
/// answer: the caller must check the time.
/// @param safe_V  voltage that make_safe() writes [V], in the command range
/// Its safe_snapshot() is a SafeSnapshot as text.
/// @throws DeviceError      no device, another board, driver, subdevice, range or resolution than `options` say (the
///                          message lists what the card offers), in use or locked by another process, or built without
///                          comedi
/// @throws PermissionError  the device node may not be opened
/// @throws ConfigError      `options` contradict themselves
/// Not thread-safe, except make_safe(), see there.
[[nodiscard]] std::unique_ptr<Rig> open_rig(const ComediOptions& options, double safe_V);

/// Reads the description of the card at a device node; changes nothing on it.
/// @throws DeviceError, PermissionError  as open_rig
[[nodiscard]] CardDescription describe_card(const std::string& device);

}  // namespace eha::hal
