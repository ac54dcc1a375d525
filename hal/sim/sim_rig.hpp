// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "hal/rig.hpp"
#include "hal/sim/sim_options.hpp"

namespace eha::hal {

/// How the simulated plant is integrated: Cylinder::advance(), or Cylinder::advance_implicitly(), which serves trials
/// of many records.
enum class Integration { exact, quick };

/// Opens the simulated electro-hydraulic actuator: Cylinder between two converters and a noisy wire sensor.
///
/// The plant's time is that of read(): a call advances it to elapsed_ns under the command held since. A time smaller
/// than the last one begins a new run: the plant continues from its present state.
///
/// Opened with the hydraulics off. While set_enable(false) holds, load-holding valves block both cylinder ports and the
/// rod holds; only the oil trapped under pressure still pushes it out by a few millimetres, over minutes, as it leaks
/// past the piston. Enabled at 0 V it creeps, because the valve's null is not at 0 V.
///
/// Equal options and calls give equal bytes on every IEEE 754 machine: the model takes only + - * / and sqrt.
/// @param safe_V  voltage that make_safe() writes [V]
/// @throws ConfigError  a parameter makes no physical sense; the message names every such one
/// Cost: a read over 1 ms takes about 3 us, a quick one a tenth. Not thread-safe.
[[nodiscard]] std::unique_ptr<Rig> open_rig(const SimOptions& options, double safe_V,
                                            Integration integration = Integration::exact);

}  // namespace eha::hal
