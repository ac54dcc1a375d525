// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/option_fault.hpp"

namespace eha::hal {

/// What an analog channel measures or drives against; spelled "ground", "common", "diff", "other" in files.
enum class AnalogReference { ground, common, diff, other };

/// One analog channel: `[comedi.feedback]` (input) and `[comedi.command]` (output).
struct AnalogChannel {
  unsigned subdevice = 0;
  unsigned channel = 0;
  AnalogReference reference = AnalogReference::ground;
  double range_min_V = -10.0;  ///< the card must offer exactly this range [V]
  double range_max_V = 10.0;
};

/// Level of a digital line that means "on"; spelled "high" and "low" in files.
enum class ActiveLevel { high, low };

/// One digital line: `[comedi.emergency_stop]` (input), `[comedi.enable]` and `[comedi.heartbeat]` (outputs).
struct DigitalLine {
  unsigned subdevice = 0;
  unsigned channel = 0;  ///< 0..31
  /// Emergency stop: the level of the closed, healthy circuit. Enable: the level that powers the hydraulics.
  /// Heartbeat: the level first written, without consequence.
  ActiveLevel active = ActiveLevel::high;
};

/// Where the card is and how it is wired, `[comedi]`. The card must be exactly what is said here: open_comedi()
/// refuses any difference and lists what the card offers.
struct ComediOptions {
  std::string device = "/dev/comedi0";
  std::string board;                   ///< name the driver reports, "pci1716"
  std::string driver;                  ///< name of the kernel driver, "adv_pci1710"
  int resolution_bits = 16;            ///< of both analog channels, 1..31
  AnalogChannel feedback;              ///< the displacement sensor
  double feedback_settling_us = 10.0;  ///< between selecting the channel and converting, 0..99 [us]
  AnalogChannel command;               ///< the valve
  std::optional<DigitalLine>
      emergency_stop;                    ///< normally closed; none only when the file says `emergency_stop = "none"`
  std::optional<DigitalLine> enable;     ///< hydraulics on; none only when the file says so
  std::optional<DigitalLine> heartbeat;  ///< toggles with every command; none only when the file says so

  // displacement_in = offset_in + scale_in_per_V * feedback_V
  double scale_in_per_V = 0.0;   ///< displacement sensor, not zero [in/V]
  double offset_in = 0.0;        ///< displacement at 0 V [in]
  std::string calibration_date;  ///< of scale and offset, YYYY-MM-DD
};

/// Every option that contradicts itself or another one, as far as that shows without the card; empty when all is well.
[[nodiscard]] std::vector<OptionFault> check(const ComediOptions& options);

}  // namespace eha::hal
