// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/text_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <tuple>

#include "core/error.hpp"
#include "core/unit_names.hpp"
#include "daemon/importer/clock_text.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/csv_fields.hpp"
#include "daemon/importer/roles.hpp"
#include "daemon/importer/two_units.hpp"
#include "daemon/record/record_csv.hpp"

namespace eha::importer {
namespace {

/// Scopes write the second as "S".
bool is_same_word(const std::string& a, const std::string& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

}  // namespace

std::vector<Column> named_columns(const Dialect& dialect, const TextLines& text, const std::filesystem::path& path) {
  std::vector<Column> columns(dialect.fields);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    Column& column = columns[i];
    if (i < dialect.names.size()) column.label = text.decoded(dialect.names[i]);
    // A name appears in messages and in the files written, so no control characters.
    if (std::any_of(column.label.begin(), column.label.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; })) {
      throw DataError(
          fmt::format("{}:{}: column {} of the header is named \"{}\"; control characters are no part of a name",
                      path.string(), dialect.header_line, i + 1, readable(column.label, kLongestShown)));
    }
    if (dialect.is_record_format) {
      const ident::Channel channel = record::channel_from_header(column.label);
      column.name = channel.name;
      column.unit = channel.unit;
    } else {
      std::tie(column.name, column.unit) = name_and_unit(column.label);
    }
    if (i >= dialect.units.size()) continue;
    const std::string below = unit_of(text.decoded(dialect.units[i]));
    if (column.unit != below && known_unit(below) && !known_unit(column.unit)) {
      if (!column.unit.empty()) column.name = column.label;  // "Weg (links)" above "mm"
      column.unit = below;
    }
    if (column.unit.empty()) column.unit = below;
    if (column.unit == below) column.name = name_without_unit(column.name, below);
    if (known_unit(below) && !is_same_word(column.unit, below)) column.other_unit = below;
  }
  // Scopes write the second as "S".
  for (Column& column : columns) {
    if (column.unit == "S" && hints_of(column.name, "").time > 0) column.unit = "s";
  }
  // "Time ms" has one as the columns beside it may have.
  const auto has_other_form = [](const Column& column) {
    return !column.unit.empty() && name_and_unit(column.label).first != column.label;
  };
  if (!dialect.units.empty() || std::any_of(columns.begin(), columns.end(), has_other_form)) return columns;
  std::vector<std::string> labels;
  for (const Column& column : columns) labels.push_back(column.label);
  const auto split = names_and_last_units(labels);
  for (std::size_t i = 0; i < split.size(); ++i) std::tie(columns[i].name, columns[i].unit) = split[i];
  return columns;
}

void sample_columns(std::vector<Column>& columns, const std::vector<std::string>& lines, const Dialect& dialect,
                    const TextLines& text) {
  CsvFields fields(dialect.delimiter);
  std::vector<std::size_t> texts(columns.size());
  std::vector<ClockReader> clocks(columns.size());
  std::size_t rows = 0;
  for (std::size_t i = dialect.first_data_line - 1; i < lines.size() && rows < kSampledRows; ++i) {
    if (is_comment(lines[i]) || !fields.split(lines[i]) || fields.size() < columns.size()) continue;
    ++rows;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      double value = 0.0;
      if (parse_number(fields[c], dialect.signs, value) == NumberKind::none) {
        ++texts[c];
        if (columns[c].sampled_text.empty()) columns[c].sampled_text = text.decoded(fields[c]);
        std::vector<std::string>& words = columns[c].words;
        const bool is_new = std::find(words.begin(), words.end(), fields[c]) == words.end();
        if (is_new && words.size() < kMostWords) words.emplace_back(fields[c]);
        if (const auto time_s = clocks[c].seconds(fields[c])) {
          columns[c].is_clock = true;
          value = *time_s;
        }
      }
      columns[c].sample.push_back(value);
    }
  }
  // One word in a column of numbers is a fault of its row, not of the column.
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const std::vector<double>& sample = columns[c].sample;
    const bool is_missing = std::all_of(sample.begin(), sample.end(), [](double x) { return std::isnan(x); });
    columns[c].is_number = 2 * texts[c] <= rows && (rows == 0 || !is_missing);
  }
  for (std::size_t c = 0; c < dialect.holds_facts.size(); ++c) {
    if (dialect.holds_facts[c]) columns[c].is_number = columns[c].is_clock = false;
  }
}

}  // namespace eha::importer
