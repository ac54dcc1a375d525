// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "core/display_unit.hpp"
#include "daemon/rig/calibration.hpp"

// Positions of the rod by a ruler with the sensor's volts there, as typed or from a file.

namespace eha::cli {

/// "2.95in=4.917" or, with decimal commas, "74,989mm=4,921". @param unit  of a position without one
/// @throws UsageError
[[nodiscard]] CalibrationPoint point_of(const std::string& text, const DisplayUnit& unit);

/// @param path  CSV with a column of lengths and one of volts   @throws DataError
[[nodiscard]] std::vector<CalibrationPoint> points_of_file(const std::string& path);

/// The unit in which all positions are typed; empty where they differ, or without one.
[[nodiscard]] std::string typed_unit(const std::vector<std::string>& pairs);

}  // namespace eha::cli
