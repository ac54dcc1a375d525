// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "hal/rig.hpp"

namespace eha {

/// Does work that takes long between the last look at the lines of an open card and the first tick: in another thread,
/// while this one reads the undriven rig fifty times a second.
/// @throws what the work throws; DeviceError, after the work, where the emergency stop was opened meanwhile, if only
/// for
///         a moment: its reset must start nothing
void with_watched_lines(hal::Rig& rig, const std::function<void()>& work);

}  // namespace eha
