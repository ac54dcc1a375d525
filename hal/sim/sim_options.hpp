// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::hal {

/// Physical parameters of the simulated actuator.
struct SimOptions {};

}  // namespace eha::hal
