// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/importer/importer_options.hpp"
#include "daemon/importer/number_signs.hpp"

namespace eha::importer {

/// How a text file writes its columns.
struct Dialect {
  char delimiter = ',';
  NumberSigns signs = {};
  std::size_t fields = 0;               ///< of a row; one that is empty in every row and last is not counted
  std::size_t header_line = 0;          ///< from 1; 0: none
  std::size_t first_data_line = 0;      ///< from 1
  std::vector<std::string> names = {};  ///< of the columns as in the file; empty without a header
  std::vector<std::string> units = {};  ///< of a row of units; empty without one
  std::vector<bool> holds_facts = {};   ///< of columns: facts beside the rows, no part of the record; empty: none
  bool is_record_format = false;        ///< a header that begins with time_s, commas and points: eha-record(5)
  bool is_of_labview = false;           ///< its rows may come in blocks with a header each: LabviewBlocks
  bool has_comma_numbers = false;       ///< some field has a decimal comma
  bool has_thousands = false;           ///< some field has signs.thousands
  std::size_t skipped_lines = 0;        ///< text before the header that is neither comment nor blank
  /// Whether a number of these lines proves the signs, an option says them, or the file is of eha.
  bool are_signs_known = false;
};

/// Finds the headers between LabVIEW's blocks of rows, one line after the other from below the first header.
class LabviewBlocks {
 public:
  /// Whether a line belongs to such a header, or is the row of names below it.
  [[nodiscard]] bool is_header(std::string_view line);
  /// Headers so far.
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  bool inside_ = false;
  bool ended_ = false;
  std::size_t count_ = 0;
};

/// A line that holds no data: blank, or one that begins with # % or //, or Excel's "sep=;".
[[nodiscard]] bool is_comment(std::string_view line);

/// Guesses the dialect from a file's first lines: of each delimiter and decimal sign that `options` leave open, the
/// pair under which most fields are numbers in lines of equal width; of pairs that are about as good one under which
/// the lines above name all columns. Those lines are the data; header_above() finds the header, or a comment of the
/// same width is it. Where numbers prove their signs (SignEvidence), these are taken.
/// @param lines  as in the file   @param path  for messages
/// @throws DataError  no two columns of numbers are found
[[nodiscard]] Dialect guess_dialect(const std::vector<std::string>& lines, const Options& options,
                                    const std::string& path);

}  // namespace eha::importer
