// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pthread.h>

#include <atomic>
#include <cstdint>

namespace eha::test {

/// A PCI-1716 with a valve and a rod behind it, in memory that the programs under test (stand_in_card.cpp, loaded
/// before libcomedi) and the test share. Zeroed memory is a card that nobody has prepared.
struct CardMemory {
  static constexpr std::uint32_t kEnable = 1;

  pthread_mutex_t mutex;  ///< comedi's: held during a call; robust and shared between processes
  double position_in = 2.95;
  std::int64_t moved_ns = 0;
  std::uint32_t dither = 0;

  // For the test to read at any time.
  std::atomic<std::uint32_t> output_code{0};
  std::atomic<std::uint32_t> digital_outputs{0};
  std::atomic<std::uint64_t> commands{0};       ///< ticks that wrote the analogue output
  std::atomic<std::int64_t> output_ns{0};       ///< CLOCK_MONOTONIC of the last write of anyone
  std::atomic<std::int64_t> enabled_ns{0};      ///< of the last change of the enable line to on
  std::atomic<std::int64_t> disabled_ns{0};     ///< to off
  std::atomic<std::int64_t> stall_begun_ns{0};  ///< of the first write that timed out

  // For the test to set.
  std::atomic<std::uint32_t> digital_inputs{1};   ///< bit 0: the emergency-stop circuit is closed
  std::atomic<std::int32_t> open_error{0};        ///< errno with which the card does not open; 0: it opens
  std::atomic<std::uint32_t> removals{0};         ///< descriptors opened before the last one say ENODEV
  std::atomic<double> dead_band_V{0.0};           ///< half width, of the valve
  std::atomic<std::int64_t> refuses_until_ns{0};  ///< CLOCK_MONOTONIC: writes before it say EIO
  std::atomic<std::int64_t> output_stall_ms{0};   ///< a write to the analogue output takes this long and then times out

  static constexpr double kGain_in_per_V_s = 0.14;  ///< twice that of the sample file's [following]

  [[nodiscard]] bool is_enabled() const { return (digital_outputs.load() & kEnable) != 0; }
};

/// Name of the environment variable with the file that holds a CardMemory.
inline constexpr const char* kCardFile = "EHA_STAND_IN_CARD";

}  // namespace eha::test
