// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/importer/clock_text.hpp"
#include "daemon/importer/importer_options.hpp"

namespace eha::importer {

/// Rows that are looked at before a file is read, to guess from.
inline constexpr std::size_t kSampledRows = 200;

/// Rows that are read of a file: 0.7 GB of three columns.
inline constexpr std::size_t kMostRows = 30'000'000;

/// Different words that are kept of a column.
inline constexpr std::size_t kMostWords = 8;

/// A column of a file, before its role is known.
struct Column {
  std::string label;            ///< as in the file: "Spannung [V]", "rec.u"; empty when the file names none
  std::string name;             ///< "Spannung"
  std::string unit;             ///< "V"; empty when unknown
  std::string other_unit = {};  ///< of the row of units, where the name says another; mostly empty
  bool is_number = true;
  /// The first kSampledRows values; NaN where one is missing. Of clocks seconds from the first.
  std::vector<double> sample;
  std::string sampled_text;             ///< the first value as written, when it is no number
  std::vector<std::string> words = {};  ///< the first different ones of those, at most kMostWords
  bool is_clock = false;                ///< dates or times of day
  std::size_t rows = 0;                 ///< columns of different lengths do not belong together; 0 when not yet known
};

/// A column of values and that of their times, from 0.
struct TimedColumn {
  std::size_t time = 0;
  std::size_t column = 0;
};

/// The rows that a caller wants.
struct Selection {
  std::vector<std::size_t> columns;                        ///< from 0, the time first if there is one
  bool has_time = false;                                   ///< the first column is the time
  double time_unit_s = 1.0;                                ///< of the time column [s]
  double from = -std::numeric_limits<double>::infinity();  ///< [s]; without a time: rows from 0
  double to = std::numeric_limits<double>::infinity();
  bool keep_missing = false;  ///< NaN for a missing value instead of a refusal
  /// From this one of `columns` on a missing value is NaN anyway.
  std::size_t may_lack_from = std::numeric_limits<std::size_t>::max();
  std::string mend_missing;  ///< the end of that refusal: the command that fills them
};

/// Numbers of a file.
struct Rows {
  std::vector<std::vector<double>> columns;  ///< [as selected][row]; a time column in seconds
  int time_decimals = 0;     ///< most digits after the point of the time [s] (negative: none, and trailing zeros)
  int time_significant = 0;  ///< most significant digits of the time
  std::vector<std::string> remarks = {};  ///< on rows that were left out, a sentence each
  bool has_lines = false;                 ///< the file is text
  std::size_t header_line = 0;
  /// (row, line) where the distance between the two changes, ascending.
  std::vector<std::pair<std::size_t, std::size_t>> line_marks;

  [[nodiscard]] std::size_t count() const { return columns.empty() ? 0 : columns.front().size(); }
  /// Line (from 1) of the file that holds a row (from 0). Cost O(log marks).
  [[nodiscard]] std::size_t line_of(std::size_t row) const;
  /// The end of "FILE:LINE" or "FILE, row ROW" (from 1).
  [[nodiscard]] std::string where(std::size_t row) const;
  [[nodiscard]] std::string header_place() const;
};

/// The columns of a file that may be a record. Not thread-safe.
class Table {
 public:
  Table() = default;
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;
  virtual ~Table() = default;

  [[nodiscard]] virtual const std::vector<Column>& columns() const = 0;
  /// The facts that were guessed: "semicolons", "decimal comma". None for a record as eha-record(5) describes it.
  [[nodiscard]] virtual const std::vector<std::string>& guesses() const = 0;
  /// Whether the file is a record as eha-record(5) describes it, its columns in that order.
  [[nodiscard]] virtual bool is_record_format() const { return false; }
  /// Whether a record says that a set point stood beside it in the file that it was imported from.
  [[nodiscard]] virtual bool says_closed_loop() const { return false; }
  /// "FILE:LINE" of the header where the file is text with one, else "FILE".
  [[nodiscard]] virtual std::string place() const = 0;
  /// The sample period that stands above the rows [s]; none where nothing says it.
  [[nodiscard]] virtual std::optional<double> told_period_s() const { return std::nullopt; }
  /// A period that is a number of the file itself, as a scalar Ts of a MAT-file.
  struct StatedPeriod {
    double step_s = 0.0;
    std::string name;
  };
  [[nodiscard]] virtual std::optional<StatedPeriod> stated_period() const { return std::nullopt; }
  /// How far apart the rows of the whole file are by a column of dates or times of day, or of days of a spreadsheet.
  /// For a refusal: the file cannot be read after that. None when it does not tell.
  [[nodiscard]] virtual std::optional<RowPeriod> period_of_rows(std::size_t /*column*/) { return std::nullopt; }
  /// How a file of text, which other programs can read, writes its rows; none for others.
  struct TextForm {
    char delimiter = ',';
    char decimal = '.';
    std::size_t first_data_line = 1;
  };
  [[nodiscard]] virtual std::optional<TextForm> text_form() const { return std::nullopt; }
  /// Reads once. @throws DataError, IoError
  [[nodiscard]] virtual Rows read(const Selection& selection, const Progress& progress) = 0;
};

/// Opens a file by its content: text, MAT-file, HDF5.
/// @throws DataError  it is of a kind that cannot be read (a workbook, an archive, a run's folder): names the way out
/// @throws IoError, PermissionError
[[nodiscard]] std::unique_ptr<Table> open_table(const std::filesystem::path& path, const Options& options);

/// The options that take the rows of a clock as even: "--period 0.01", and --from and --to where it pauses.
/// @param unit_s  of the clock [s]
[[nodiscard]] std::string period_options(const RowPeriod& period, double unit_s = 1.0);

/// What the rows of a clock tell of the sample period, with the command that takes it.
[[nodiscard]] std::string period_offer(const RowPeriod& period, const std::filesystem::path& path,
                                       const Options& options);

}  // namespace eha::importer
