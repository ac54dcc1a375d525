// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "daemon/acquisition/tick_record.hpp"

namespace eha::record {

/// Converts ticks to the evenly spaced rows of the experiment: row k applied `voltage_V` from k ticks after the first
/// running one. A displacement that was not measured (a skipped tick, a read that timed out, a gap) is interpolated
/// linearly between its measured neighbours, held at the ends, and listed. The voltage of such a row is known, because
/// the output holds it; that of a row lost from a damaged journal is interpolated, too. Memory: the longest gap.
class ExperimentRows {
 public:
  using Emit = std::function<void(std::size_t row, double voltage_V, double displacement_in)>;

  explicit ExperimentRows(Emit emit) : emit_(std::move(emit)) {}

  /// Takes the ticks in recorded order.
  void add(std::span<const acquisition::TickRecord> ticks);
  /// Call after the last tick.
  void finish();

  [[nodiscard]] std::size_t rows() const { return next_row_; }
  [[nodiscard]] const std::vector<std::size_t>& interpolated() const { return interpolated_; }  ///< ascending
  [[nodiscard]] std::size_t lost() const { return lost_; }  ///< of the interpolated ones: lost from a damaged journal

 private:
  void add_measured(double voltage_V, double displacement_in);
  void add_unmeasured(double voltage_V);
  void learn_voltage(double voltage_V);
  void release(double until_in);

  Emit emit_;
  std::vector<double> waiting_V_;  ///< voltages of the unmeasured rows since the last measured one
  std::size_t next_row_ = 0;       ///< rows taken, waiting ones included
  std::vector<std::size_t> interpolated_;
  std::size_t lost_ = 0;
  std::size_t without_V_ = 0;  ///< rows at the end of waiting_V_ whose voltage is not known yet
  std::uint32_t first_sequence_ = 0;
  bool has_first_ = false;
  bool has_measured_ = false;
  double last_V_ = 0.0;
  double last_in_ = 0.0;
};

}  // namespace eha::record
