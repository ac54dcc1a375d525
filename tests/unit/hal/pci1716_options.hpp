// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "hal/comedi/comedi_options.hpp"

namespace eha::hal::testing {

/// A PCI-1716 wired as in the shipped config/rigs/pci1716.toml.
inline ComediOptions pci1716_options() {
  ComediOptions options;
  options.board = "pci1716";
  options.driver = "adv_pci1710";
  options.feedback = {
      .subdevice = 0, .channel = 0, .reference = AnalogReference::diff, .range_min_V = 0, .range_max_V = 10};
  options.command = {
      .subdevice = 1, .channel = 0, .reference = AnalogReference::ground, .range_min_V = -5, .range_max_V = 5};
  options.emergency_stop = DigitalLine{.subdevice = 2, .channel = 0, .active = ActiveLevel::high};
  options.enable = DigitalLine{.subdevice = 3, .channel = 0, .active = ActiveLevel::high};
  options.heartbeat = DigitalLine{.subdevice = 3, .channel = 1, .active = ActiveLevel::high};
  options.scale_in_per_V = 0.6;
  options.calibration_date = "2026-01-15";
  return options;
}

}  // namespace eha::hal::testing
