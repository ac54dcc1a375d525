// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/importer/table.hpp"

namespace eha::importer {

/// What each column of a record is, from 0.
struct Roles {
  std::optional<std::size_t> time = {};  ///< none: period_s is the step
  std::optional<double> period_s = {};   ///< [s]; as --period gives it, or the file
  std::string period_name = {};          ///< of the number in the file that gives it
  std::size_t input = 0;
  std::optional<std::size_t> output = {};  ///< none: only an input was asked for
  std::optional<std::size_t> filled = {};  ///< 1 in rows that were filled, 0 in measured ones
  bool time_unit_assumed = false;          ///< the file does not say that its time is in seconds
  bool by_order = false;                   ///< names and units do not say which is input and which output
};

/// The last column of a record that `eha import --resample` wrote.
inline constexpr std::string_view kFilledColumn = "filled";

/// Finds time, input and output: as the options say, else by names and units of English, German and French, else, of
/// exactly three columns, by their order. Columns that number the rows and columns of text are left out. With --period
/// a column that --time names is neither input nor output.
/// @throws DataError   more than one choice is left: lists the columns, and gives a command that works
/// @throws UsageError  an option names no column, or one of text
[[nodiscard]] Roles find_record(Table& table, const std::filesystem::path& path, const Options& options);

/// Finds time and input for a model. @param unit  of the model's input: of several columns the one in it is taken, and
/// one in another unit is refused; empty: any
[[nodiscard]] Roles find_input(Table& table, const std::filesystem::path& path, const Options& options,
                               const std::string& unit);

/// Seconds in one unit of the time column. @throws DataError  its unit is none of time
[[nodiscard]] double time_unit_s(const Column& time, const std::filesystem::path& path, const Options& options);

/// A column for a message: `2 "Spannung [V]"`.
[[nodiscard]] std::string described(const std::vector<Column>& columns, std::size_t index);
/// The same with the unit where the label does not say it: `2 "Spannung" [V]`.
[[nodiscard]] std::string described_with_unit(const std::vector<Column>& columns, std::size_t index);

}  // namespace eha::importer
