// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "core/display_unit.hpp"
#include "ident/valve/valve_sheet.hpp"

// The one finding of a leak: every answer about the rig of a leaky valve sheet has this sentence and this remedy.

namespace eha::ident {

/// Speed within the dead band that counts as a leak, as the command that gives it [V]; of the following check, see
/// FOLLOWING in eha-rig(5).
inline constexpr double kWantedNull_V = 0.03;

/// A rod that moves within its valve's dead band.
struct Leak {
  double creep_in_per_s = 0.0;  ///< to either side
  double as_V = 0.0;            ///< command that would move the rod as fast
};

/// The leak that a valve sheet shows. @param gain  of either direction [in/(V s)]
/// @returns none below kWantedNull_V, or where the dead band was too narrow to see it
[[nodiscard]] std::optional<Leak> leak_of(double creep_in_per_s, double gain_positive, double gain_negative);
[[nodiscard]] std::optional<Leak> leak_of(const ValveSheet& sheet);

/// "the rod creeps at 0.017 in/s within the dead band, as 0.14 V of command would move it: oil leaks past the piston or
/// through the valve"
[[nodiscard]] std::string leak_text(const Leak& leak, const DisplayUnit& unit);

/// The same as sentences, with what follows from it and what to do.
[[nodiscard]] std::string leak_finding(const Leak& leak, const DisplayUnit& unit);

/// What comes first on a rig that leaks.
inline constexpr const char* kRepairFirst =
    "repair the leak first; then `eha characterise`, the experiment again with the new rig file, and `eha tune` with "
    "that run";

/// What comes first where the moving rod shows another valve, and no sheet tells whether oil leaks.
inline constexpr const char* kMeasureFirst =
    "`eha characterise` measures the valve; where its sheet shows a leak, repair that and measure again. Then play the "
    "model's experiment again with the new rig file, and `eha tune` with that run";

}  // namespace eha::ident
