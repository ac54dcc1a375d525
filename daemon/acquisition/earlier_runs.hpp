// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "daemon/acquisition/following_monitor.hpp"

namespace eha::acquisition {

/// The way that the volts of placings asked for and the sensor did not show, since it last showed all of it.
struct LackingWay {
  double way_in = 0.0;
  double asked_in = 0.0;  ///< that was due meanwhile
  double asked_s = 0.0;   ///< for so long
};

/// What the runs before on a rig leave to the next one, which goes on counting from there. Each run by itself may be
/// too short to show that the sensor is dead, or slip by too little.
struct EarlierRuns {
  MissingMotion missing_in{};
  double slipped_in = 0.0;  ///< sum of the steps of the reading that no rod makes (SlipMonitor) [in]
  LackingWay lacking = {};
};

}  // namespace eha::acquisition
