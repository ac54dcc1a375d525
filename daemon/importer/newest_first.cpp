// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/newest_first.hpp"

#include <algorithm>
#include <cmath>

#include "daemon/importer/clock_text.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/csv_fields.hpp"

namespace eha::importer {
namespace {

constexpr std::size_t kFewestToTurn = 3;

enum class Course { falls, rises, neither };

Course course_of(const std::vector<double>& times) {
  if (times.size() < kFewestToTurn) return Course::neither;
  const auto has_step = [&](const auto& is) {
    return std::adjacent_find(times.begin(), times.end(), is) != times.end();
  };
  const bool rises = has_step([](double a, double b) { return !(b <= a); });
  const bool falls = has_step([](double a, double b) { return !(b >= a); });
  if (rises == falls) return Course::neither;
  return falls ? Course::falls : Course::rises;
}

/// Times of the first rows of a column that shows minutes only; empty for another one.
std::vector<double> minutes_of(std::size_t column, const std::vector<std::string>& lines, const Dialect& dialect) {
  CsvFields fields(dialect.delimiter);
  ClockReader reader;
  std::vector<double> times;
  for (std::size_t i = dialect.first_data_line - 1; i < lines.size() && times.size() < kSampledRows; ++i) {
    if (is_comment(lines[i]) || !fields.split(lines[i]) || fields.size() <= column) continue;
    const auto time_s = reader.seconds(with_seconds(fields[column]));
    if (!time_s) return {};
    times.push_back(*time_s);
  }
  return times;
}

}  // namespace

bool is_newest_first(const std::vector<Column>& columns, const std::vector<std::string>& lines,
                     const Dialect& dialect) {
  bool falls = false;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Column& column = columns[i];
    const bool are_minutes = !column.is_number && !column.is_clock && is_clock_of_minutes(column.sampled_text);
    const Hints hints = hints_of(column.name, column.unit);
    const bool is_named = column.is_number && hints.time > 0 && !hints.is_temperature;
    if (!are_minutes && !is_named && !(column.is_clock && !column.is_number)) continue;
    const Course course = course_of(are_minutes ? minutes_of(i, lines, dialect) : column.sample);
    if (course == Course::rises) return false;
    falls = falls || course == Course::falls;
  }
  return falls;
}

void turn_round(std::vector<double>& values, bool from_first) {
  std::reverse(values.begin(), values.end());
  if (!from_first || values.empty() || !std::isfinite(values.front())) return;
  const double first = values.front();
  for (double& value : values) value -= first;
}

}  // namespace eha::importer
