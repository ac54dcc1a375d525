// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace eha::importer {

/// Seconds of a date and time or a time of day in digits: "2024-03-01 10:00:00.25", "2024-03-01T10:00:00", "01.03.2024
/// 10:00:00,25", "03/01/2024 10:00:00", "10:00:00.25"; none for other text. No time zone applies. Only for differences
/// within a day: whether 01.03. is in January or in March does not matter then.
[[nodiscard]] std::optional<double> clock_seconds(std::string_view text);

/// How far apart rows are by a clock that shows whole units only: the step of the rows, or where it lies.
struct RowPeriod {
  std::size_t rows = 0;
  double span_s = 0.0;    ///< from the first time to the last
  double lowest_s = 0.0;  ///< the period is between these
  double highest_s = 0.0;
  double roundest_s = 0.0;                  ///< of the numbers between them the one with the fewest digits
  std::optional<std::size_t> restart = {};  ///< row (from 0) where the clock goes back; the rows before it are counted
};

/// Takes the times of the rows of a file, one after the other.
class RowClock {
 public:
  /// @param quantum_s  value of the last digit shown [s]   @param wraps  at midnight: a time of day without a date
  void add(double time_s, double quantum_s, bool wraps);
  /// None where the clock never moved.
  [[nodiscard]] std::optional<RowPeriod> period() const;

 private:
  std::size_t rows_ = 0;
  double first_s_ = 0.0;
  double last_s_ = 0.0;
  double day_s_ = 0.0;
  double quantum_s_ = 0.0;
  std::size_t changes_ = 0;
  std::size_t first_change_ = 0;  ///< row
  std::size_t last_change_ = 0;
  double first_change_s_ = 0.0;
  std::optional<std::size_t> restart_;
};

}  // namespace eha::importer
