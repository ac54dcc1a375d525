// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "hal/sim/sim_options.hpp"
#include "hal/sim/sim_rig.hpp"
#include "ident/record.hpp"

namespace eha::replay {

/// Simulates the displacement [in] of the cylinder for the voltages of a record, each held until the next row, from
/// options.initial_displacement_in at rest: N rows, row k just before voltage k takes effect. Without converters,
/// sensor and noise. @throws ConfigError  the options make no physical sense
/// Cost: about 0.1 us a sub-step; 50 s in steps of 50 us some 0.2 s.
[[nodiscard]] Eigen::VectorXd displacement_in(const hal::SimOptions& options,
                                              const Eigen::Ref<const Eigen::VectorXd>& volts, double step_s);

/// Simulates the rig's record of a table of volts, converters and noise included.
/// @param seed  of the sensor's noise, instead of the options' own
/// @throws ConfigError  the options make no physical sense
/// Cost: some 0.2 s for 50 s in steps of 1 ms, a tenth of that where the integration is quick.
[[nodiscard]] ident::Record recorded(const hal::SimOptions& options, const Eigen::Ref<const Eigen::VectorXd>& volts,
                                     double step_s, std::uint64_t seed,
                                     hal::Integration integration = hal::Integration::exact);

/// Returns the record's output in inches.
/// @throws DataError  the input is not in V, or the output neither in in nor in mm
[[nodiscard]] Eigen::VectorXd measured_in(const ident::Record& record);

/// Returns the options with the rod at the record's first position, limited to the end stops.
[[nodiscard]] hal::SimOptions starting_at(hal::SimOptions options, double displacement_in);

}  // namespace eha::replay
