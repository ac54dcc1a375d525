// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "core/display_unit.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::identify {

/// What the record of a run shows of the travel or velocity limit that ended it, where that is more than the limit.
struct TripCause {
  bool is_of_sensor = false;               ///< the readings moved and not the rod; else the rod drifted
  double speed_in_per_s = 0.0;             ///< of the rod: over the last 0.1 s, or its drift
  double noise_in = 0.0;                   ///< standard deviation of a reading
  std::optional<double> offset_V = {};     ///< that stops the drift; none within the command limits
  std::optional<double> rehearsed_V = {};  ///< the same by [following] alone, as the rehearsal has it
  bool is_other_valve = false;             ///< rods with the valve of [following] stay clear of the limits
  bool is_clear_from_middle = false;  ///< they stay clear of the limits from mid-travel, and the run began elsewhere
  bool is_unmeasured = false;         ///< the rig file has no [following], so that no rehearsal showed the way
};

/// @returns none for another fault, and a run whose excitation is too large
[[nodiscard]] std::optional<TripCause> trip_cause(const record::LoadedRun& run);

/// The cause as a sentence, without capital and point.
[[nodiscard]] std::string sentence_of(const TripCause& cause, const DisplayUnit& unit);

/// What to do before the run is played again, without capital and point: "set offset_V = -0.214 in [excitation] of the
/// experiment file".
[[nodiscard]] std::string remedy_of(const TripCause& cause);

}  // namespace eha::identify
