// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace eha::importer {

/// Choices that replace a guess; an unset one is guessed.
struct Options {
  /// A column: its name, `struct.field` or `group.dataset`, or its number from 1.
  std::optional<std::string> time = {};
  std::optional<std::string> input = {};
  std::optional<std::string> output = {};
  std::optional<char> delimiter = {};           ///< of text: ',' ';' '|' tab, or ' ' for any number of blanks
  std::optional<char> decimal = {};             ///< of text: '.' or ','
  std::optional<char> thousands = {};           ///< of text, between groups of three digits: ',' '.' or '\''
  std::optional<double> period_s = {};          ///< [s]; replaces the time column
  std::optional<double> from_s = {};            ///< [s] of the file's time; earlier rows are left out
  std::optional<double> to_s = {};              ///< [s] of the file's time; later rows are left out
  std::optional<std::string> input_unit = {};   ///< known_unit(); replaces what the file says
  std::optional<std::string> output_unit = {};  ///< the same of the output
  std::size_t input_late = 0;                   ///< rows by which the input's column comes late: it is shifted back
  bool resample = false;                        ///< fill gaps and missing values, and move rows to an even time grid
  bool keep_lone_rows = false;                  ///< take rows that stand alone as measured
  /// The command that asked, quoted for a shell; refusals extend it to one that works. Empty: "eha import FILE".
  std::string command = {};
  /// Instead of `command`: one that takes none of these options, and follows on an imported copy.
  std::string then = {};
};

/// Whether an option says what the columns and the times of a file are.
[[nodiscard]] inline bool names_columns_or_times(const Options& o) {
  return o.time || o.input || o.output || o.delimiter || o.decimal || o.thousands || o.period_s || o.input_unit ||
         o.output_unit || o.input_late > 0 || o.resample || o.keep_lone_rows;
}

/// Whether an option says how a record is to be read: of its columns and times, or which rows.
[[nodiscard]] inline bool says_how_to_read(const Options& o) { return names_columns_or_times(o) || o.from_s || o.to_s; }

/// Called in the calling thread now and then. @param share  done so far, 0..1   @param step  "r.csv: 200000 rows"
using Progress = std::function<void(double share, const std::string& step)>;

}  // namespace eha::importer
