// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace eha::hal::testing {

/// A PCI-1716 in place of libcomedi's: the functions of the library that the backend calls are defined in the test
/// program, which the linker prefers. One card for the process.
struct StandInCard {
  enum class Write { output, enable_off, enable_on, heartbeat };

  std::vector<Write> writes;      ///< every write tried, in order
  bool output_times_out = false;  ///< writes to the analogue output fail with ETIME
  bool enable_refused = false;    ///< writes to the enable line fail with EIO
  int open_error = 0;             ///< errno with which comedi_open() fails; 0: it opens
  int open_failures = 1 << 30;    ///< so often; then it opens
  std::size_t port_lines = 0;     ///< digital lines go both ways, so many together; 0: a line has one direction
  std::array<std::array<unsigned, 16>, 4> directions{};  ///< of a subdevice's lines
  int removals = 0;                                      ///< descriptors opened before the last one say ENODEV
  unsigned digital_outputs = 0;                          ///< bit 0 is the enable line
  unsigned output_code = 0;                              ///< held by the analogue output
  unsigned feedback_code = 32768;                        ///< what the analogue input reads
};

[[nodiscard]] StandInCard& stand_in_card();

}  // namespace eha::hal::testing
