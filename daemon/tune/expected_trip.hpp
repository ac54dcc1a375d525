// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "config/experiment_kind.hpp"
#include "config/rig_config.hpp"
#include "core/display_unit.hpp"
#include "daemon/acquisition/limit_monitor.hpp"
#include "hal/sim/sim_options.hpp"

namespace eha::tune {

/// End of a trial by a check of the rig, on a simulated rig that nothing is wrong with.
struct ExpectedTrip {
  acquisition::Breach breach;
  double at_s = 0.0;
  double command_V = 0.0;   ///< at that time
  bool is_of_leak = false;  ///< without leakage the same trial does not trip
};

/// Plays a controller's trial on a simulated rig under the checks of a rig file, as a run does: TrackSource and the
/// following check. None if no check ends it. The rod begins at initial_displacement_in, or
/// in mid-travel where that is beyond a limit.
/// Cost: some 0.15 s for a trial of 160 s.
[[nodiscard]] std::optional<ExpectedTrip> expected_trip(const config::Track& track, const config::RigLimits& limits,
                                                        const hal::SimOptions& rig);

/// The beginning of sentence_of(), by which a controller's file is known.
inline constexpr std::string_view kTrialTrips = "The trial (`eha track`) will trip on this rig";

/// Says for the answer of `eha tune` that the trial trips, why, and what to do.
[[nodiscard]] std::string sentence_of(const ExpectedTrip& trip, const config::RigLimits& limits);

}  // namespace eha::tune
