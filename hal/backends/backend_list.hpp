// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <variant>

#include "hal/comedi/comedi_rig.hpp"
#include "hal/sim/sim_rig.hpp"

namespace eha::hal {

/// Every backend that a rig file can name; backend.hpp lists what each must provide.
using Backend = std::variant<SimOptions, ComediOptions>;

}  // namespace eha::hal
