// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "hal/rig.hpp"

namespace eha::acquisition {

/// A rod that moves at a speed proportional to the voltage while enabled. Records every output.
class FakeRig : public hal::Rig {
 public:
  struct Write {
    double voltage_V;
    bool enabled;
  };

  explicit FakeRig(bool moves_machine = false) {
    capabilities_.backend = "fake";
    capabilities_.command_min_V = -10.0;
    capabilities_.command_max_V = 10.0;
    capabilities_.command_lsb_V = 20.0 / 65535.0;
    capabilities_.feedback_min_V = -10.0;
    capabilities_.feedback_max_V = 10.0;
    capabilities_.feedback_lsb_V = 20.0 / 65535.0;
    capabilities_.has_emergency_stop = true;
    capabilities_.has_enable = true;
    capabilities_.moves_machine = moves_machine;
    capabilities_.has_virtual_clock = !moves_machine;
    writes_.reserve(kWritesKept);
  }

  /// Gives it an auxiliary contact that follows the enable line at once.
  void add_contact(double allowed_s) {
    capabilities_.has_enable_contact = true;
    capabilities_.enable_contact_time_s = allowed_s;
  }

  [[nodiscard]] const hal::RigCapabilities& capabilities() const noexcept override { return capabilities_; }

  hal::RigStatus read(std::int64_t elapsed_ns, hal::RigReading& reading) noexcept override {
    const double duration_s = static_cast<double>(elapsed_ns - elapsed_ns_) * 1e-9;
    elapsed_ns_ = elapsed_ns;
    if (enabled_) position_in_ += gain_in_per_s_V * voltage_V_ * duration_s;
    // The code's last bits alternate, as those of a noisy converter do.
    dither_ = !dither_;
    reading = hal::RigReading{};
    reading.displacement_in = position_in_;
    reading.feedback_V = position_in_;
    reading.feedback_code = static_cast<std::uint32_t>(std::lround(position_in_ * 3276.8)) * 2 + (dither_ ? 1 : 0);
    reading.digital_inputs = 0x5;
    reading.enable_contact = capabilities_.has_enable_contact && enabled_;
    return hal::RigStatus::ok;
  }

  hal::RigStatus command(double command_V, hal::AppliedCommand& applied) noexcept override {
    if (!std::isfinite(command_V)) return hal::RigStatus::not_finite;
    voltage_V_ = command_V;
    applied = {command_V, static_cast<std::uint32_t>(std::lround((command_V + 10.0) / 20.0 * 65535.0))};
    note();
    return hal::RigStatus::ok;
  }

  hal::RigStatus set_enable(bool on) noexcept override {
    if (on && !written_) return hal::RigStatus::io_error;
    enabled_ = on;
    note();
    return hal::RigStatus::ok;
  }

  hal::RigStatus make_safe() noexcept override {
    ++safe_calls;
    if (safe_failures > 0) {
      --safe_failures;
      return hal::RigStatus::io_error;
    }
    voltage_V_ = 0.0;
    enabled_ = false;
    note();
    return hal::RigStatus::ok;
  }

  /// Every output, in order.
  [[nodiscard]] const std::vector<Write>& writes() const { return writes_; }
  [[nodiscard]] bool is_safe() const { return std::abs(voltage_V_) < 1e-12 && !enabled_; }
  [[nodiscard]] bool enabled() const { return enabled_; }

  double gain_in_per_s_V = 1.0;
  int safe_failures = 0;  ///< how many of the next make_safe() calls fail
  int safe_calls = 0;

 private:
  static constexpr std::size_t kWritesKept = 200'000;

  void note() {
    written_ = true;
    if (writes_.size() < kWritesKept) writes_.push_back({voltage_V_, enabled_});
  }

  hal::RigCapabilities capabilities_;
  double position_in_ = 3.0;
  double voltage_V_ = 0.0;
  std::int64_t elapsed_ns_ = 0;
  bool enabled_ = false;
  bool written_ = false;
  bool dither_ = false;
  std::vector<Write> writes_;
};

}  // namespace eha::acquisition
