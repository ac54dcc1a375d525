// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "config/rig_config.hpp"
#include "daemon/eha/console.hpp"

namespace eha::cli {

/// Range of volts, slew and travel that a rig allows a designed excitation about the valve's null, less margins.
struct ExcitationRoom {
  double peak_V = 0.0;
  double slew_V_per_s = 0.0;
  double travel_in = 0.0;        ///< to either side of the middle
  double gain_in_per_V_s = 0.0;  ///< of the rod, the mean of both directions
  double null_V = 0.0;
  double dead_band_V = 0.0;
};

/// @throws ConfigError  the rig has no [following], which predicts the travel
[[nodiscard]] ExcitationRoom excitation_room(const config::RigConfig& rig);

/// Returns the ticks between compared rows: at least ten compared rows in the shortest period, 40 ms for slow
/// excitations.
[[nodiscard]] int compared_ticks(double highest_Hz, double tick_s);

/// Warns of an excitation that barely leaves the dead band.
void warn_of_dead_band(double rms_V, const ExcitationRoom& room, Console& console);

}  // namespace eha::cli
