// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace eha::importer {

/// Seconds of a date and time or a time of day in digits: "2024-03-01 10:00:00.25", "2024-03-01T10:00:00", "01.03.2024
/// 10:00:00,25", "03/01/2024 10:00:00:250", "03/01/2024 2:00:00 PM", "10:00:00.25", of minutes and seconds with a
/// fraction, "00:07,3", or of a number with a unit of time, "0.01 sec"; none for other text. No time zone applies. Only
/// for differences within a day: whether 01.03. is in January or in March does not matter then.
[[nodiscard]] std::optional<double> clock_seconds(std::string_view text);

/// Value of the last digit that a clock shows [s]. @param text  of which clock_seconds() is known
[[nodiscard]] double clock_quantum_s(std::string_view text);

/// Reads the clocks of a column, one row after the other.
class ClockReader {
 public:
  /// Seconds from the first row, to the digits shown, at most microseconds; none for other text. A time of day without
  /// a date goes on over midnight, and back over it where the newest row is the first.
  [[nodiscard]] std::optional<double> seconds(std::string_view text);
  /// Digits behind the point of the finest one so far.
  [[nodiscard]] int decimals() const { return decimals_; }

 private:
  std::optional<double> first_s_;
  double last_s_ = 0.0;
  double day_s_ = 0.0;
  bool falls_ = false;  ///< the newest row is the first
  int decimals_ = 0;
};

/// Whether text is a clock that a spreadsheet shows without its seconds: "14:03", "25.11.2026 14:03".
[[nodiscard]] bool is_clock_of_minutes(std::string_view text);

/// Such a clock with the seconds that it does not show: "14:03:00", "11/25/2026 2:03:00 PM".
[[nodiscard]] std::string with_seconds(std::string_view text);

/// How far apart rows are by a clock that shows whole units only: the step of the rows, or where it lies.
struct RowPeriod {
  std::size_t rows = 0;
  double span_s = 0.0;    ///< from the first time to the last
  double lowest_s = 0.0;  ///< the period is between these
  double highest_s = 0.0;
  double roundest_s = 0.0;                  ///< of the numbers between them the one with the fewest digits
  std::optional<std::size_t> restart = {};  ///< row (from 0) where the clock goes back; the rows before it are counted

  /// The clock goes on while rows are missing.
  struct Pause {
    std::size_t row = 0;  ///< from 0, the first after it
    double length_s = 0.0;
    bool is_within = false;  ///< of a clock that shows several rows alike: rows are missing somewhere in that time
  };
  std::optional<Pause> longest_pause = {};
  std::size_t pauses = 0;
  /// With pauses the longest part without one, else all rows; rows, span and period are of it. From 0.
  std::size_t first_row = 0;
  std::size_t end_row = 0;  ///< the one behind it
  bool is_part = false;     ///< rows follow it that it leaves out
};

/// Takes the times of the rows of a file, one after the other.
class RowClock {
 public:
  /// @param quantum_s  value of the last digit shown [s]
  void add(double time_s, double quantum_s);
  /// None where the clock never moved.
  [[nodiscard]] std::optional<RowPeriod> period() const;

 private:
  /// A row that shows another time than the one before it; the first row too.
  struct Change {
    std::size_t row = 0;
    double time_s = 0.0;
  };

  [[nodiscard]] std::vector<std::size_t> pauses(double typical_s) const;
  [[nodiscard]] double typical_period_s() const;
  void set_bounds(RowPeriod& found, std::size_t first, std::size_t last, std::size_t end_row) const;

  std::size_t rows_ = 0;
  std::vector<Change> changes_;
  double quantum_s_ = 0.0;
  std::optional<std::size_t> restart_;
};

}  // namespace eha::importer
