// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace eha::hal {

/// All data needed to make an opened card safe without its rig file: the card's own numbers, found when it was opened.
struct SafeSnapshot {
  struct Line {
    unsigned subdevice = 0;
    unsigned channel = 0;
    unsigned off_level = 0;         ///< 0 or 1: the level that switches the hydraulics off
    bool is_bidirectional = false;  ///< the subdevice must be set to output
  };
  std::string device;      ///< "/dev/comedi0"
  std::string board;       ///< the card at `device` must report this name
  unsigned subdevice = 0;  ///< analog output
  unsigned channel = 0;
  unsigned range = 0;      ///< index of the range
  unsigned reference = 0;  ///< comedi's aref
  unsigned safe_code = 0;  ///< converter code of the safe voltage
  double safe_V = 0.0;     ///< for messages [V]
  std::optional<Line> enable;
};

/// The snapshot as JSON, {"schema": "eha-safe/1", "backend": "comedi", ...}.
[[nodiscard]] std::string to_text(const SafeSnapshot& snapshot);

/// @throws ConfigError  not a snapshot; the message names `file_name` and the key
[[nodiscard]] SafeSnapshot safe_snapshot_from_text(std::string_view text, std::string_view file_name);

class ComediDevice;

/// The card of a snapshot. Once open it stays open until the kernel reports its removal; then it is opened again.
/// Not thread-safe.
class SafeCard {
 public:
  explicit SafeCard(SafeSnapshot snapshot);
  SafeCard(const SafeCard&) = delete;
  SafeCard& operator=(const SafeCard&) = delete;
  ~SafeCard();

  [[nodiscard]] const SafeSnapshot& snapshot() const noexcept { return snapshot_; }

  /// @returns whether the card is open and is the snapshot's board
  bool keep_open() noexcept;

  /// Switches the enable line off and writes the safe code; retries every 10 ms for at most `patience` after any
  /// failure. A failure of one does not prevent the other from being tried.
  /// @throws DeviceError      still not safe, or the board is another one; names the line that is not safe
  /// @throws PermissionError  the device node may not be opened
  void make_safe(std::chrono::milliseconds patience);

  /// Switches the enable line off in one try. Works while the driving process runs, which locks no output line's
  /// subdevice; waits for a call of that process in the kernel to return.
  /// @returns whether the line is off; false also without one
  bool switch_off() noexcept;

 private:
  [[nodiscard]] ComediDevice& device();

  SafeSnapshot snapshot_;
  std::unique_ptr<ComediDevice> device_;
};

}  // namespace eha::hal
