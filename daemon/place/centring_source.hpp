// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "config/characterisation.hpp"
#include "daemon/acquisition/command_source.hpp"
#include "daemon/place/learned_monitor.hpp"
#include "daemon/place/loop_monitor.hpp"

namespace eha::place {

/// A table of volts, and a loop that keeps the rod about the middle of its travel whatever the valve's null is. Needs
/// no prediction, unlike HoldSource: for measuring the valve, not for identifying the rod. Real-time safe. Not
/// thread-safe.
class CentringSource final : public acquisition::CommandSource {
 public:
  /// @param table_V  must outlive this
  /// @param learned  of a rig without [following]
  CentringSource(std::span<const double> table_V, const config::Centring& centring, const LoopMonitor& monitor,
                 const std::optional<LearnedMonitor>& learned)
      : table_(table_V, 1), centring_(centring), monitor_(monitor), learned_(learned) {}

  [[nodiscard]] std::uint32_t rows() const noexcept override { return table_.rows(); }
  [[nodiscard]] std::uint32_t rows_per_repetition() const noexcept override { return table_.rows_per_repetition(); }
  [[nodiscard]] double voltage_V(std::uint32_t row, const hal::RigReading& last) noexcept override {
    if (learned_ && has_begun_) learned_->note(command_V_, last.displacement_in);
    has_begun_ = true;
    const double correction_V = centring_.correction_V(last.displacement_in);
    command_V_ = table_.voltage_V(row, last) + shift_V_ + correction_V;
    monitor_.note(command_V_, std::abs(correction_V) >= centring_.most_V, last);
    return command_V_;
  }
  /// Adds this to every voltage: the valve's null was found. Call before the first row.
  void shift_by(double volts) noexcept { shift_V_ = volts; }

  [[nodiscard]] acquisition::Breach breach() const noexcept override {
    if (learned_ && learned_->breach().fault != acquisition::Fault::none) return learned_->breach();
    return monitor_.breach();
  }

 private:
  acquisition::TableSource table_;
  config::Centring centring_;
  LoopMonitor monitor_;
  std::optional<LearnedMonitor> learned_;
  double shift_V_ = 0.0;
  double command_V_ = 0.0;
  bool has_begun_ = false;
};

}  // namespace eha::place
