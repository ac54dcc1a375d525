// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace eha::hal {

/// Voltage ranges of a rig's converters, and the calibration of its displacement sensor:
///   displacement_in = offset_in + scale_in_per_V feedback_V
struct Conversion {
  double command_min_V = 0.0;  ///< output converter [V]
  double command_max_V = 0.0;
  double feedback_min_V = 0.0;  ///< input converter [V]
  double feedback_max_V = 0.0;
  double scale_in_per_V = 0.0;   ///< [in/V]
  double offset_in = 0.0;        ///< displacement at 0 V [in]
  std::string calibration_date;  ///< of scale and offset, YYYY-MM-DD; empty if the rig needs no calibration
};

}  // namespace eha::hal
