// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <string>

#include "config/rig_config.hpp"
#include "core/millimetre_key.hpp"

namespace eha::config {

/// "[start]" of an experiment that begins at the middle of the travel, in millimetres for a rig with units = "mm";
/// without an end of line.
[[nodiscard]] inline std::string start_at_middle(const RigConfig& rig) {
  const bool is_metric = rig.units == "mm";
  return fmt::format(
      "[start]\ndisplacement_{} = {:.{}f}", is_metric ? "mm" : "in",
      0.5 * (is_metric ? kMillimetresPerInch : 1.0) * (rig.limits.travel_min_in + rig.limits.travel_max_in),
      is_metric ? 1 : 3);
}

}  // namespace eha::config
