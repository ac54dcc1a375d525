// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace eha::importer {

/// The signs of the numbers of a file.
struct NumberSigns {
  char decimal = '.';
  char thousands = '\0';  ///< between groups of three digits: ',' '.' or '\''; NUL: none
};

/// Whether `sign` separates groups of three digits, the first of one to three.
[[nodiscard]] bool are_groups(std::string_view digits, char sign);

/// Whether a text has digits in groups: "1.234,5", "1,234.5", "1 234,5" with any blank, "1'234.5".
[[nodiscard]] bool has_thousands_separator(std::string_view field);

/// Gathers what the numbers of a file tell about their signs. One file has one decimal sign.
///
/// A sign before three digits and behind one to three that do not begin with 0 ("74,973") may be decimal or separate
/// thousands. Any other number with one sign ("0,123", "12,5", "1234,567") has it for decimals. "1.234,5" and
/// "1,234,567" have both or one for thousands. A column with ten different whole numbers beside such numbers
/// ("998", "1,000") has it for thousands, unless whole numbers in it lack the sign: those of five digits, and beside
/// "1,000" those of four, which Spanish or Polish leave as they are before "10.000".
class SignEvidence {
 public:
  /// @param delimiter  of the columns: between commas a point is decimal unless commas are in numbers too
  explicit SignEvidence(char delimiter) : delimiter_(delimiter) {}

  void add(std::size_t column, std::string_view field);

  /// Where some number proves it. None where no number has a sign, or both signs are proved decimal.
  [[nodiscard]] std::optional<NumberSigns> proved() const;

  /// A number that may be read in two ways, and its column.
  struct Ambiguous {
    std::size_t column = 0;
    std::string number;  ///< "74,973"
    char sign = ',';
  };
  /// None where proved(), or where no number has a sign.
  [[nodiscard]] std::optional<Ambiguous> ambiguous() const;
  /// Of a thousands sign that whole numbers prove: "998 and 1,000".
  [[nodiscard]] std::string proof_by_whole_numbers() const;

 private:
  /// The whole numbers of a column, and those that may be grouped by either sign.
  struct Numbers {
    std::vector<std::string> whole = {};  ///< the first different ones of up to four digits, not 0
    bool has_four_digits = false;
    bool has_five_digits = false;
    std::array<std::string, 2> grouped = {};      ///< the first for ',' and for '.'
    std::array<bool, 2> groups_four_digits = {};  ///< "1,000"

    /// Whether a sign before three digits cannot separate thousands here.
    [[nodiscard]] bool lack(std::size_t sign) const {
      return !grouped[sign].empty() && (has_five_digits || (has_four_digits && groups_four_digits[sign]));
    }
  };

  [[nodiscard]] bool is_decimal(std::size_t sign) const;
  [[nodiscard]] bool is_grouped(std::size_t sign) const;
  [[nodiscard]] const Numbers* column_of_thousands(std::size_t sign) const;

  char delimiter_;
  bool has_apostrophes_ = false;
  std::array<bool, 2> only_decimal_ = {};    ///< some number has ',' or '.' for decimals for certain
  std::array<bool, 2> only_thousands_ = {};  ///< ... between thousands
  std::vector<Numbers> columns_;
};

}  // namespace eha::importer
