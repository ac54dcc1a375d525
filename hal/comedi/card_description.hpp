// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "hal/comedi/comedi_options.hpp"

namespace eha::hal {

enum class SubdeviceKind { analog_input, analog_output, digital_input, digital_output, digital_io, other };

/// One range of an analog subdevice.
struct VoltageRange {
  unsigned index = 0;  ///< comedi's number for it
  double min_V = 0.0;
  double max_V = 0.0;
};

/// One subdevice of a card.
struct SubdeviceDescription {
  SubdeviceKind kind = SubdeviceKind::other;
  unsigned channels = 0;
  unsigned last_code = 0;                   ///< of channel 0: 65535 for 16 bits
  std::vector<AnalogReference> references;  ///< supported by its channels
  std::vector<VoltageRange> ranges;         ///< of channel 0; those in volts only
};

/// Description of a card by its driver.
struct CardDescription {
  std::string board;
  std::string driver;
  std::vector<SubdeviceDescription> subdevices;
};

/// The card's indices of the ranges and lines that the options name.
struct CardMatch {
  unsigned feedback_range = 0;
  unsigned command_range = 0;
  unsigned last_code = 0;
  bool enable_is_bidirectional = false;  ///< the line must be switched to output first
  bool heartbeat_is_bidirectional = false;
  bool emergency_stop_is_bidirectional = false;
  bool enable_contact_is_bidirectional = false;
};

/// Finds the channels, ranges and lines of `options` on the card.
/// @throws DeviceError  anything differs; one line a difference, each with the card's alternatives
[[nodiscard]] CardMatch match(const ComediOptions& options, const CardDescription& card);

/// Describes the card, one line a subdevice: "subdevice 1: analog output, 2 channels, 16 bit, -5..5, -10..10 V".
[[nodiscard]] std::string to_lines(const CardDescription& card);

[[nodiscard]] const char* name(AnalogReference reference) noexcept;

}  // namespace eha::hal
