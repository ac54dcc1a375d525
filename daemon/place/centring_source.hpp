// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "config/characterisation.hpp"
#include "daemon/acquisition/command_source.hpp"
#include "daemon/place/learned_monitor.hpp"
#include "daemon/place/loop_monitor.hpp"
#include "daemon/place/sheet_pace.hpp"

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
    double from_null_V = table_.voltage_V(row, last) - null_V_;
    if (pace_) from_null_V = pace_->paced_V(row, from_null_V);
    const double wanted_V = null_V_ + shift_V_ + std::clamp(from_null_V + correction_V, -most_V_, most_V_);
    command_V_ = std::clamp(wanted_V, command_V_ - most_step_V_, command_V_ + most_step_V_);
    monitor_.note(command_V_, std::abs(correction_V) >= centring_.most_V, last);
    return command_V_;
  }
  /// A valve whose null and gain were found. Call before the first row.
  /// @param null_V    that the table was made about   @param shift_V  added to every voltage
  /// @param most_V    greatest voltage from the null, and of the loop's part
  /// @param most_step_V  by the slew limit in a tick: a command that is limited only afterwards would not be the one
  ///                     that moves the rod, and motion would be missed that the valve does not yet give
  void set(double null_V, double shift_V, double most_V, double most_step_V, const SheetPace& pace) noexcept {
    null_V_ = null_V;
    shift_V_ = shift_V;
    most_V_ = most_V;
    most_step_V_ = most_step_V;
    command_V_ = null_V + shift_V;
    centring_.most_V = std::min(centring_.most_V, most_V);
    pace_ = pace;
  }

  [[nodiscard]] acquisition::Breach breach() const noexcept override {
    if (learned_ && learned_->breach().fault != acquisition::Fault::none) return learned_->breach();
    return monitor_.breach();
  }

 private:
  acquisition::TableSource table_;
  config::Centring centring_;
  LoopMonitor monitor_;
  std::optional<LearnedMonitor> learned_;
  double null_V_ = 0.0;
  double shift_V_ = 0.0;
  double most_V_ = std::numeric_limits<double>::infinity();
  double most_step_V_ = std::numeric_limits<double>::infinity();
  std::optional<SheetPace> pace_;
  double command_V_ = 0.0;
  bool has_begun_ = false;
};

}  // namespace eha::place
