// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "config/rig_config.hpp"
#include "hal/rig.hpp"

namespace eha {

/// Findings on the protection that a rig file gives the machine, in sentences for its owner; each names the key and an
/// allowed value. A rig that moves no machine has warnings only, of what is no number of a rig.
struct ArmingFindings {
  std::vector<std::string> refusals;  ///< the rig is not armed while there is one of these
  std::vector<std::string> warnings;  ///< the rig is armed, with less protection than possible
};

/// Judges a rig file. Refused are limits that protect from nothing (a safe voltage that drives the valve, a velocity,
/// slew, deceleration or following limit that nothing reaches), numbers of [following] that no valve of such a rig has,
/// what judge_realtime() refuses, and a sensor whose open wire reads as a place within the travel. Warned of are a
/// missing [following], without which only [characterise] is played, or [sensor], an unknown open_circuit_V, a priority
/// that the guard could not preempt and a travel that may be in another unit.
[[nodiscard]] ArmingFindings arming_findings(const config::RigConfig& rig);

/// Opens a rig, whose output is then at its safe voltage.
/// @throws ConfigError  a machine without an enable line would move at that voltage, or might by a null that nothing
///                      shows to be measured, or its file is a sample: nothing is put out
/// @throws DeviceError, PermissionError, ConfigError  as hal::open
[[nodiscard]] std::unique_ptr<hal::Rig> open_at_rest(const config::RigConfig& rig);

/// What an open rig is like while nothing drives it: "at 0 V with the hydraulics off".
[[nodiscard]] std::string rest_text(const config::RigConfig& rig);

/// @throws ConfigError  all refusals of arming_findings(), one a line
void require_protecting_limits(const config::RigConfig& rig);

/// Reads the inputs of a rig with its hydraulics off twenty times in 0.44 s (20 ticks, if longer), and refuses readings
/// that a sound rig does not give: an open emergency-stop circuit, a closed contact of the enable contactor, a sensor
/// outside its valid band or at the end of the converter, or noise or drift that the following check could take for
/// motion. Blocks for that time.
/// @throws Error (safety_trip)   gives the reading and the part to check   @throws DeviceError  the rig cannot be read
void require_plausible_inputs(hal::Rig& rig, const config::RigConfig& config);

}  // namespace eha
