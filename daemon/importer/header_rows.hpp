// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "daemon/importer/number_signs.hpp"

namespace eha::importer {

/// What a line is under one delimiter and decimal sign.
struct Line {
  std::size_t number = 0;  ///< from 1
  std::vector<std::string> fields;
  std::size_t numbers = 0;  ///< fields that are numbers or missing values, at least one of them a number
  bool has_comma_number = false;
};

/// The lines of a text under one delimiter and decimal sign, and how well it explains them.
struct Reading {
  char delimiter = ',';
  NumberSigns signs = {};
  std::vector<Line> lines;
  std::size_t fields = 0;
  std::size_t numbers = 0;  ///< most in one of the lines that have `fields`
  double score = 0.0;

  /// Of "rate,1000" above rows of two numbers only half are numbers.
  [[nodiscard]] bool is_data(const Line& line) const {
    return line.fields.size() == fields && 2 * line.numbers > numbers;
  }
};

/// Names and units above the rows.
struct Header {
  std::vector<std::string> names = {};  ///< of the columns as in the file; empty without a header
  std::vector<std::string> units = {};  ///< empty without a row of units
  std::size_t line = 0;                 ///< of the names, from 1; 0: none
  std::size_t skipped_lines = 0;        ///< above the header
};

/// Whether the fields are the names of columns: words, no numbers and no dates.
[[nodiscard]] bool are_names(const std::vector<std::string>& fields);

/// Finds names and units above the rows. The lowest row that holds units is taken for them, and the next above it that
/// holds names; other rows (of hardware, of dates) of as many fields may stand between or below. Without units the line
/// above the rows holds the names, or the next above it that has any.
/// @param first  of reading.lines, that of the first row   @param width  columns, without an empty one at the end
/// @param all_lines  of the file, what LabVIEW writes above its measurement among them
[[nodiscard]] Header header_above(const Reading& reading, std::size_t first, std::size_t width,
                                  const std::vector<std::string>& all_lines);

}  // namespace eha::importer
