// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>

#include "config/characterisation.hpp"
#include "daemon/acquisition/command_source.hpp"

namespace eha::place {

/// A table of volts, and a loop that keeps the rod about the middle of its travel whatever the valve's null is. Needs
/// no prediction, unlike HoldSource: for measuring the valve, not for identifying the rod. Real-time safe. Not
/// thread-safe.
class CentringSource final : public acquisition::CommandSource {
 public:
  /// @param table_V  must outlive this
  CentringSource(std::span<const double> table_V, const config::Centring& centring)
      : table_(table_V, 1), centring_(centring) {}

  [[nodiscard]] std::uint32_t rows() const noexcept override { return table_.rows(); }
  [[nodiscard]] std::uint32_t rows_per_repetition() const noexcept override { return table_.rows_per_repetition(); }
  [[nodiscard]] double voltage_V(std::uint32_t row, const hal::RigReading& last) noexcept override {
    return table_.voltage_V(row, last) + centring_.correction_V(last.displacement_in);
  }

 private:
  acquisition::TableSource table_;
  config::Centring centring_;
};

}  // namespace eha::place
