// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <csv.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/importer/number_signs.hpp"

namespace eha::importer {

/// The fields of one line of delimited text, split by libcsv; at blanks (delimiter ' ') any number of them separates.
/// All characters are in one string, so that a line costs no allocation. Not thread-safe.
class CsvFields {
 public:
  explicit CsvFields(char delimiter);
  CsvFields(const CsvFields&) = delete;
  CsvFields& operator=(const CsvFields&) = delete;
  ~CsvFields();

  /// @returns false when a quotation mark is out of place; then there are no fields
  [[nodiscard]] bool split(std::string_view line);
  [[nodiscard]] std::size_t size() const { return ends_.size(); }
  [[nodiscard]] std::string_view operator[](std::size_t i) const {
    const std::size_t begin = i == 0 ? 0 : ends_[i - 1];
    return std::string_view(text_).substr(begin, ends_[i] - begin);
  }

 private:
  static void add(void* field, std::size_t length, void* self);
  void start_parser();

  csv_parser parser_{};
  char delimiter_;
  std::string cleaned_;  ///< the line without the no-break spaces in its numbers
  std::string text_;
  std::vector<std::size_t> ends_;
};

enum class NumberKind { finite, missing, not_finite, none };

/// "#WERT!", "#N/A": what a spreadsheet shows instead of a number.
[[nodiscard]] bool is_spreadsheet_error(std::string_view field);

/// Reads a whole field as a number. No locale applies. A thousands sign is taken between groups of three digits only.
/// @param value  set when finite, else NaN
/// missing: empty, or what programs write for a missing value (NaN, NA, null, #N/A, -) or an overload (the sign of
/// infinity)
[[nodiscard]] NumberKind parse_number(std::string_view field, NumberSigns signs, double& value);

/// Digits of a number that parse_number has taken.
struct Precision {
  int decimals = 0;     ///< after the point; negative: none, and trailing zeros by an exponent
  int significant = 0;  ///< digits without leading zeros
};
[[nodiscard]] Precision precision_of(std::string_view field, char decimal);

}  // namespace eha::importer
