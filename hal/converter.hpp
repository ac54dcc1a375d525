// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>

namespace eha::hal {

/// An ideal converter whose codes 0 .. 2^bits - 1 spread evenly over a closed range of volts, as comedi counts them.
/// Real-time safe.
class Converter {
 public:
  /// @param min_V, max_V  voltages of the first and the last code, min_V < max_V [V]
  /// @param bits          1..31
  Converter(double min_V, double max_V, int bits) noexcept
      : min_V_(min_V), max_V_(max_V), last_code_((std::uint32_t{1} << bits) - 1) {}

  /// Nearest code; volts outside the range give the first or the last one. `volts` must not be NaN.
  [[nodiscard]] std::uint32_t code(double volts) const noexcept {
    if (volts <= min_V_) return 0;
    if (volts >= max_V_) return last_code_;
    return static_cast<std::uint32_t>(std::floor((volts - min_V_) / (max_V_ - min_V_) * last_code_ + 0.5));
  }
  /// Voltage of a code [V].
  [[nodiscard]] double volts(std::uint32_t code) const noexcept {
    return min_V_ + (max_V_ - min_V_) * code / last_code_;
  }
  [[nodiscard]] double lsb_V() const noexcept { return (max_V_ - min_V_) / last_code_; }
  [[nodiscard]] std::uint32_t last_code() const noexcept { return last_code_; }
  [[nodiscard]] bool at_rail(std::uint32_t code) const noexcept { return code == 0 || code >= last_code_; }

 private:
  double min_V_;
  double max_V_;
  std::uint32_t last_code_;
};

}  // namespace eha::hal
