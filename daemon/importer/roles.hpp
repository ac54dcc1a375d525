// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "daemon/importer/imported_table.hpp"
#include "daemon/importer/importer_options.hpp"

namespace eha::importer {

/// What each column of a record is, from 0.
struct Roles {
  std::optional<std::size_t> time = {};  ///< none: period_s is the step
  std::optional<double> period_s = {};   ///< [s]; as --period gives it, or the file
  std::string period_name = {};          ///< of the number in the file that gives it
  /// The column of times where a period replaces it: that of --time, else one that rises evenly and has no name.
  std::optional<std::size_t> replaced_time = {};
  std::string time_note = {};  ///< what other columns of times say, for the line of guesses
  /// The output's own times where it has some: the same, or later or earlier by a part of a step.
  std::optional<std::size_t> output_time = {};
  std::size_t input = 0;
  std::optional<std::size_t> output = {};  ///< none: only an input was asked for
  std::optional<std::size_t> filled = {};  ///< 1 in rows that were filled, 0 in measured ones
  bool time_unit_assumed = false;          ///< the file does not say that its time is in seconds
  bool by_order = false;                   ///< names and units do not say which is input and which output
};

/// Which columns a record is made of is a question.
class ColumnsAsked : public DataError {
 public:
  /// @param question  with the columns   @param answer  the likeliest one, as options of a command
  ColumnsAsked(std::string question, Options answer, const std::string& command)
      : DataError(question + " For example: `" + command + "`"),
        question_(std::move(question)),
        answer_(std::move(answer)),
        command_(command) {}

  [[nodiscard]] const std::string& question() const { return question_; }
  [[nodiscard]] const Options& answer() const { return answer_; }
  [[nodiscard]] const std::string& command() const { return command_; }

 private:
  std::string question_;
  Options answer_;
  std::string command_;
};

/// The last column of a record that `eha import --resample` wrote.
inline constexpr std::string_view kFilledColumn = "filled";

/// Finds time, input and output: as the options say, else by names and units of English, German and French, else, of
/// exactly three columns, by their order. Columns that number the rows and columns of text are left out. With --period
/// a column that --time names is neither input nor output, nor, without --time, the first that rises evenly and has no
/// name, where two others are left.
/// @throws ColumnsAsked  more than one choice is left: lists the columns, and gives a command that works
/// @throws UsageError  an option names no column, or one of text
[[nodiscard]] Roles find_record(Table& table, const std::filesystem::path& path, const Options& options);

/// Finds time and input for a model. @param unit  of the model's input: of several columns the one in it is taken, and
/// one in a unit of another kind is refused; empty: any
[[nodiscard]] Roles find_input(Table& table, const std::filesystem::path& path, const Options& options,
                               const std::string& unit);

/// Seconds in one unit of a time column without a unit whose values count from 1970; none where they do not.
[[nodiscard]] std::optional<double> epoch_unit_s(const Column& time);

/// Seconds in one unit of the time column. @throws DataError  its unit is none of time
[[nodiscard]] double time_unit_s(const Column& time, const std::filesystem::path& path, const Options& options);

/// The same of Roles::output_time, which without a unit is in that of the time.
[[nodiscard]] double output_time_unit_s(const std::vector<Column>& columns, const Roles& roles,
                                        const std::filesystem::path& path, const Options& options);

}  // namespace eha::importer
