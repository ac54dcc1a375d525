// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
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

  /// @param source  of the ticks, for messages
  ExperimentRows(std::string source, Emit emit) : source_(std::move(source)), emit_(std::move(emit)) {}

  /// Takes the ticks in recorded order.
  /// @throws DataError  their numbers do not rise, or more than a million have no row
  void add(std::span<const acquisition::TickRecord> ticks);
  /// Call after the last tick.
  void finish();

  [[nodiscard]] std::size_t rows() const { return next_row_; }
  [[nodiscard]] const std::vector<std::size_t>& interpolated() const { return interpolated_; }  ///< ascending
  [[nodiscard]] std::size_t lost() const { return lost_; }  ///< of the interpolated ones: lost from a damaged journal

 private:
  void require_next(std::uint64_t sequence, std::uint64_t due) const;
  void add_measured(double voltage_V, double displacement_in);
  void add_unmeasured(double voltage_V);
  void learn_voltage(double voltage_V);
  void release(double until_in);

  std::string source_;
  Emit emit_;
  std::vector<double> waiting_V_;  ///< voltages of the unmeasured rows since the last measured one
  std::size_t next_row_ = 0;       ///< rows taken, waiting ones included
  std::vector<std::size_t> interpolated_;
  std::size_t lost_ = 0;
  std::uint64_t missing_ = 0;  ///< of the interpolated ones: without a row of their own
  std::size_t without_V_ = 0;  ///< rows at the end of waiting_V_ whose voltage is not known yet
  std::uint32_t first_sequence_ = 0;
  bool has_first_ = false;
  bool has_measured_ = false;
  double last_V_ = 0.0;
  double last_in_ = 0.0;
};

}  // namespace eha::record
