// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "config/rig_config.hpp"

namespace eha {

/// What the limits of a rig file leave unwatched, or make of the rig: a sentence each with the key, its value and what
/// to do. The rig is armed all the same; arming_findings() has what it is not armed with. Said of are a check for a
/// frozen sensor that is off or late, a loop that may be late for long, a velocity limit below the speed of a placing,
/// a calibration of the sensor that is more than a year old, and a safe voltage outside the valve's dead band. These
/// bounds are this project's own, not from a standard.
[[nodiscard]] std::vector<std::string> limit_remarks(const config::RigConfig& rig, std::chrono::sys_days today);

/// The same of today.
[[nodiscard]] std::vector<std::string> limit_remarks(const config::RigConfig& rig);

}  // namespace eha
