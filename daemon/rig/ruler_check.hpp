// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "config/rig_config.hpp"
#include "core/display_unit.hpp"

namespace eha {

/// Whether [characterise] on a rig is its first valve measurement: nothing but a ruler can show a wrong calibration of
/// the sensor before the rod moves.
[[nodiscard]] bool needs_ruler(const config::RigConfig& rig);

/// Compares the sensor with a ruler, within 0.1 in. @param ruler_in  none: nobody has read one   @param shown_in  by
/// the sensor [in]   @param unit  of lengths in the message
/// @throws UsageError  no reading   @throws ConfigError  they differ, or the reading is no number
void require_agreement_with_ruler(std::optional<double> ruler_in, double shown_in, const DisplayUnit& unit);

/// Compares the sensor with a ruler, within what slips before a run trips, 0.05 in. @param ruler_in  finite [in]
/// @param shown_in  by the sensor [in]   @param unit  of lengths in the message
/// @throws ConfigError  they differ
void require_place_by_ruler(double ruler_in, double shown_in, const DisplayUnit& unit);

}  // namespace eha
