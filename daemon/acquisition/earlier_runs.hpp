// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "daemon/acquisition/following_monitor.hpp"

namespace eha::acquisition {

/// What the runs before on a rig leave to the next one, which goes on counting from there. Each run by itself may be
/// too short to show that the sensor is dead, or slip by too little.
struct EarlierRuns {
  MissingMotion missing_in{};
  double slipped_in = 0.0;  ///< sum of the steps of the reading that no rod makes (SlipMonitor) [in]
};

}  // namespace eha::acquisition
