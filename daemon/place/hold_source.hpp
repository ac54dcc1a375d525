// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "config/hold_law.hpp"
#include "daemon/acquisition/command_source.hpp"
#include "daemon/place/loop_monitor.hpp"

namespace eha::place {

/// A table of volts with a slow proportional loop about the displacement that it is predicted to cause:
///   u = r + config::HoldLaw(middle + x - y)
/// r the table [V], x the prediction [in], y the displacement [in]. With a constant reference the loop would remove the
/// slowest tones. With the prediction as reference it removes only the unpredicted motion: the drift of an integrating
/// rod. The loop's part of a row is its requested voltage less the table's. Real-time safe. Not thread-safe.
class HoldSource final : public acquisition::CommandSource {
 public:
  /// @param predicted_in  as long as the table; must outlive this, as must the table
  HoldSource(std::span<const double> table_V, std::span<const double> predicted_in, std::uint32_t repetitions,
             const config::HoldLaw& law, const LoopMonitor& monitor)
      : table_(table_V, repetitions), predicted_in_(predicted_in), law_(law), monitor_(monitor) {}

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
    const double correction_V = law_.correction_V(off_in);
    const double command_V = table_.voltage_V(row, last) + correction_V;
    monitor_.note(command_V, std::abs(correction_V) >= law_.most_V, last);
    return command_V;
  }
  [[nodiscard]] acquisition::Breach breach() const noexcept override { return monitor_.breach(); }

 private:
  acquisition::TableSource table_;
  std::span<const double> predicted_in_;
  config::HoldLaw law_;
  LoopMonitor monitor_;
  double middle_in_ = 0.0;
  bool has_begun_ = false;
};

}  // namespace eha::place
