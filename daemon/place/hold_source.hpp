// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "daemon/acquisition/command_source.hpp"

namespace eha::place {

/// A table of volts with a slow proportional loop about the displacement that it is predicted to cause:
///   u = r + clamp(gain (middle + x - y), +-most)
/// r the table [V], x the prediction [in], y the displacement [in]. With a constant reference the loop would remove the
/// slowest tones. With the prediction as reference it removes only the unpredicted motion: the drift of an integrating
/// rod. The loop's part of a row is its requested voltage less the table's. Real-time safe. Not thread-safe.
class HoldSource final : public acquisition::CommandSource {
 public:
  /// @param predicted_in  as long as the table; must outlive this, as must the table
  /// @param gain_V_per_in, most_V  positive
  HoldSource(std::span<const double> table_V, std::span<const double> predicted_in, std::uint32_t repetitions,
             double gain_V_per_in, double most_V)
      : table_(table_V, repetitions), predicted_in_(predicted_in), gain_V_per_in_(gain_V_per_in), most_V_(most_V) {}

  [[nodiscard]] std::uint32_t rows() const noexcept override { return table_.rows(); }
  [[nodiscard]] std::uint32_t rows_per_repetition() const noexcept override { return table_.rows_per_repetition(); }
  [[nodiscard]] double voltage_V(std::uint32_t row, const hal::RigReading& last) noexcept override {
    const double predicted_in = predicted_in_[row % predicted_in_.size()];
    if (!has_begun_) {
      // The first row that is asked for: the ramp to it begins here.
      has_begun_ = true;
      middle_in_ = last.displacement_in - predicted_in;
    }
    const double off_in = middle_in_ + predicted_in - last.displacement_in;
    return table_.voltage_V(row, last) + std::clamp(gain_V_per_in_ * off_in, -most_V_, most_V_);
  }

 private:
  acquisition::TableSource table_;
  std::span<const double> predicted_in_;
  double gain_V_per_in_;
  double most_V_;
  double middle_in_ = 0.0;
  bool has_begun_ = false;
};

}  // namespace eha::place
