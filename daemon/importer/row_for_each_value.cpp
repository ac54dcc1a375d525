// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/row_for_each_value.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "core/shell_word.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/column_text.hpp"

namespace eha::importer {
namespace {

bool is_channel_name(const std::string& word) {
  return !word.empty() && word.find_first_of("\"'\\`") == std::string::npos;
}

bool names_channels(const Column& column) {
  return !column.is_number && !column.is_clock && column.words.size() > 1 && column.words.size() < kMostWords &&
         std::all_of(column.words.begin(), column.words.end(), is_channel_name);
}

}  // namespace

std::string row_for_each_value(const Table& table, std::size_t time, std::size_t value,
                               const std::filesystem::path& path, const Options& options) {
  const std::vector<Column>& columns = table.columns();
  const auto form = table.text_form();
  const auto channel = std::find_if(columns.begin(), columns.end(), names_channels);
  if (!form || form->delimiter == ' ' || channel == columns.end()) return {};
  const std::vector<std::string>& names = channel->words;
  const auto hinted = [&](int Hints::*kind) {
    return std::find_if(names.begin(), names.end(), [&](const std::string& name) {
      const auto [bare, unit] = name_and_unit(name);
      return hints_of(bare, unit).*kind > 0;
    });
  };
  auto input = hinted(&Hints::input);
  auto output = hinted(&Hints::output);
  if (input == names.end() || output == names.end() || input == output) {
    input = names.begin();
    output = input + 1;
  }
  const std::string sign = form->delimiter == '\t' ? "\\t" : std::string(1, form->delimiter);
  const std::string columns_file = path.stem().string() + "-columns" + path.extension().string();
  const auto at = static_cast<std::size_t>(channel - columns.begin());
  // A row is written where both channels have a value of one time.
  const std::string awk = fmt::format(
      R"(awk -F'{0}' 'BEGIN{{print "time{0}{2}{0}{5}"}} ${1}=="{2}"{{u=${3};a=${4}}} ${1}=="{5}"{{y=${3};b=${4}}} )"
      R"(a==b&&a!=c""{{print a "{0}" u "{0}" y;c=a}}')",
      sign, at + 1, *input, value + 1, time + 1, *output);
  return fmt::format(
      "; column {} names the channel of each row: `{} {} > {}` puts {} as the input and {} as the output beside the "
      "time, then `{}`",
      described(columns, at), awk, shell_word(path.string()), shell_word(columns_file), *input, *output,
      command_on(options, path, columns_file));
}

}  // namespace eha::importer
