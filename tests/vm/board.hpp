// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace eha::test {

/// A comedi board of the test machine, /dev/comedi0 while this lives: "comedi_test" (the kernel's own, outputs wired
/// to inputs) or "pci1716_card" (card/pci1716_card.c).
/// @throws std::runtime_error  the module does not load or the device does not appear
class Board {
 public:
  /// @param parameters  of the module, as "rod=1"
  explicit Board(std::string module, const char* parameters = "");
  Board(const Board&) = delete;
  Board& operator=(const Board&) = delete;
  ~Board();

  /// Writes a module parameter: the faults of the stand-in card.
  void set(const std::string& parameter, int value) const;
  [[nodiscard]] int get(const std::string& parameter) const;

 private:
  std::string module_;
};

/// One change of a wire of the stand-in card.
struct WireChange {
  std::int64_t time_ns = 0;  ///< CLOCK_MONOTONIC [ns]
  std::string wire;          ///< "ao0", "ao1", "do"
  std::int64_t value = 0;    ///< [uV], or the digital word
};

/// The wires of the stand-in card, now.
struct Wire {
  std::int64_t ao0_uV = 0;
  std::int64_t digital_outputs = 0;
};

[[nodiscard]] Wire read_wire();

/// The newest 4096 changes, oldest first.
[[nodiscard]] std::vector<WireChange> read_wire_changes();

/// How pci1716.toml wires the stand-in card.
inline constexpr std::int64_t kEnableBit = 1;
inline constexpr std::int64_t kHeartbeatBit = 2;
inline constexpr double kHalfLsb_uV = 10e6 / 0xffff;  ///< by which the safe voltage may be missed
inline constexpr const char* kNoisyRod = "rod=1 ai_noise=1";

/// The output is at 0 V within half a step, and the hydraulics are off.
[[nodiscard]] bool wire_is_safe();

/// CLOCK_MONOTONIC [ns]
[[nodiscard]] std::int64_t now_ns();

/// When the enable line went off for good, CLOCK_MONOTONIC [ns]; kNeverOff while it is on.
inline constexpr std::int64_t kNeverOff = -1;
[[nodiscard]] std::int64_t off_since_ns();

/// Where the rod behind the stand-in card truly is [in].
[[nodiscard]] double true_place_in(const Board& board);

}  // namespace eha::test
