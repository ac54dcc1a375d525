// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/dialect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "core/error.hpp"
#include "core/text.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/csv_fields.hpp"

namespace eha::importer {
namespace {

/// In order of preference where two explain a file equally well.
constexpr std::string_view kDelimiters = ",;\t| ";
constexpr std::string_view kDecimals = ".,";

/// What a line is under one dialect.
struct Line {
  std::size_t number = 0;  ///< from 1
  std::vector<std::string> fields;
  std::size_t numbers = 0;  ///< fields that are numbers or missing values, at least one of them a number
  bool has_comma_number = false;
};

Line parsed(const std::string& text, std::size_t number, CsvFields& splitter, char decimal) {
  Line line;
  line.number = number;
  if (!splitter.split(text)) return line;
  std::size_t finite = 0;
  for (std::size_t i = 0; i < splitter.size(); ++i) {
    line.fields.emplace_back(splitter[i]);
    double value = 0.0;
    const NumberKind kind = parse_number(splitter[i], decimal, value);
    if (kind == NumberKind::finite) ++finite;
    if (kind == NumberKind::finite || (kind == NumberKind::missing && !splitter[i].empty())) ++line.numbers;
    if (kind == NumberKind::finite && decimal == ',' && splitter[i].find(',') != std::string_view::npos) {
      line.has_comma_number = true;
    }
  }
  if (finite == 0) line.numbers = 0;
  return line;
}

/// The lines under one dialect, and how well it explains them.
struct Reading {
  char delimiter = ',';
  char decimal = '.';
  std::vector<Line> lines;
  std::size_t fields = 0;
  std::size_t numbers = 0;  ///< most in one of the lines that have `fields`
  double score = 0.0;

  /// Of "rate,1000" above rows of two numbers only half are numbers.
  [[nodiscard]] bool is_data(const Line& line) const {
    return line.fields.size() == fields && 2 * line.numbers > numbers;
  }
};

Reading read_as(const std::vector<std::string>& texts, char delimiter, char decimal) {
  Reading reading{.delimiter = delimiter, .decimal = decimal, .lines = {}};
  CsvFields splitter(delimiter);
  std::map<std::size_t, double> score_of_width;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    if (is_comment(texts[i])) continue;
    Line line = parsed(texts[i], i + 1, splitter, decimal);
    if (line.numbers > 0) {
      const auto numbers = static_cast<double>(line.numbers);
      const bool ends_empty = line.fields.size() > 1 && line.fields.back().empty();
      const auto width = static_cast<double>(line.fields.size() - (ends_empty ? 1 : 0));
      score_of_width[line.fields.size()] += numbers * numbers / width;
    }
    reading.lines.push_back(std::move(line));
  }
  for (const auto& [width, score] : score_of_width) {
    if (score <= reading.score) continue;
    reading.fields = width;
    reading.score = score;
  }
  for (const Line& line : reading.lines) {
    if (line.fields.size() == reading.fields) reading.numbers = std::max(reading.numbers, line.numbers);
  }
  return reading;
}

std::string first_text(const std::vector<std::string>& lines) {
  const auto first = std::find_if_not(lines.begin(), lines.end(), is_comment);
  return first == lines.end() ? "" : readable(*first, kLongestShown);
}

/// A comment just above the data that has as many words as the data has columns, as numpy.savetxt writes its header.
std::vector<std::string> names_in_comment(const std::vector<std::string>& lines, std::size_t data_line,
                                          const Reading& reading) {
  if (data_line < 2) return {};
  std::string_view comment = lines[data_line - 2];
  const std::size_t begin = comment.find_first_not_of("#%/ \t");
  if (!is_comment(comment) || begin == std::string_view::npos) return {};
  CsvFields splitter(reading.delimiter);
  if (!splitter.split(comment.substr(begin)) || splitter.size() != reading.fields) return {};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < splitter.size(); ++i) names.emplace_back(splitter[i]);
  return names;
}

/// Takes the header from the line or the two lines above the data.
void take_header(const Reading& reading, std::size_t first, Dialect& dialect) {
  const auto is_header = [&](const Line& line) {
    // The names of R's write.table lack one for the row numbers; LabVIEW's have one for comments, which rows may lack.
    const bool has_comment = line.fields.size() == reading.fields + 1 && line.fields.back() == "Comment";
    return line.fields.size() == reading.fields || line.fields.size() + 1 == reading.fields || has_comment;
  };
  const auto is_empty = [](const Line& line) {
    return std::all_of(line.fields.begin(), line.fields.end(), [](const std::string& f) { return f.empty(); });
  };
  // Delimiters alone separate a header from its rows in some programs' files.
  std::size_t begin = first;
  while (begin > 0 && is_empty(reading.lines[begin - 1])) --begin;
  std::size_t name_row = begin;
  if (begin > 0 && is_header(reading.lines[begin - 1])) {
    name_row = begin - 1;
    const Line& last = reading.lines[begin - 1];
    // dSPACE names its rows: "unit,s,V,mm".
    const bool says_unit = last.fields.front() == "unit" || last.fields.front() == "units";
    const bool are_units = std::all_of(last.fields.begin() + (says_unit ? 1 : 0), last.fields.end(), may_be_unit);
    if (begin > 1 && are_units && is_header(reading.lines[begin - 2])) {
      dialect.units = last.fields;
      if (says_unit) dialect.units.front().clear();
      name_row = begin - 2;
    }
  }
  dialect.skipped_lines = std::min(name_row, begin);
  if (name_row == begin) return;
  dialect.names = reading.lines[name_row].fields;
  dialect.header_line = reading.lines[name_row].number;
  if (dialect.names.size() + 1 == reading.fields) dialect.names.insert(dialect.names.begin(), "");
  if (dialect.units.size() + 1 == reading.fields) dialect.units.insert(dialect.units.begin(), "");
}

/// Whether every field that is not empty is a unit, and some are.
bool are_units(const std::vector<std::string>& fields) {
  return std::all_of(fields.begin(), fields.end(), may_be_unit) &&
         std::any_of(fields.begin(), fields.end(), [](const std::string& field) { return !field.empty(); });
}

/// Takes names and units from rows that are not just above the data: ControlDesk's, which are named in their first
/// field
/// ("path", "unit"), catman's, below whose units a row names the hardware, and LabVIEW's Y_Unit_Label.
/// @param all_lines  of the file, what LabVIEW writes above its measurement among them
void take_distant_header(const Reading& reading, std::size_t first, const std::vector<std::string>& all_lines,
                         Dialect& dialect) {
  const auto suits = [&](const Line& line) {
    return line.fields.size() == reading.fields ||
           (line.fields.size() == reading.fields + 1 && line.fields.back().empty());
  };
  const auto take = [&](std::vector<std::string>& into, const Line& line) {
    into = line.fields;
    into.resize(reading.fields);
  };
  for (std::size_t i = 0; i < first; ++i) {
    const Line& line = reading.lines[i];
    if (!suits(line)) continue;
    const std::string& word = line.fields.front();
    const bool has_more = std::any_of(line.fields.begin() + 1, line.fields.end(),
                                      [](const std::string& field) { return !field.empty(); });
    if (word == "path" && has_more) {
      take(dialect.names, line);
      dialect.names.front().clear();
      dialect.header_line = line.number;
    } else if ((word == "unit" || word == "units") && are_units({line.fields.begin() + 1, line.fields.end()})) {
      take(dialect.units, line);
      dialect.units.front().clear();
    } else if (i > 0 && i + 2 == first && are_units(line.fields) && suits(reading.lines[i - 1]) &&
               !are_units(reading.lines[i - 1].fields)) {
      take(dialect.units, line);
      take(dialect.names, reading.lines[i - 1]);
      dialect.header_line = reading.lines[i - 1].number;
    }
  }
  const auto labels = std::find_if(all_lines.begin(), all_lines.end(),
                                   [](const std::string& line) { return line.starts_with("Y_Unit_Label"); });
  CsvFields splitter(reading.delimiter);
  if (!dialect.units.empty() || labels == all_lines.end() || !splitter.split(*labels)) return;
  dialect.units.assign(reading.fields, "");
  for (std::size_t i = 1; i < std::min(reading.fields, splitter.size()); ++i) dialect.units[i] = splitter[i];
}

/// Takes Yokogawa's rows of names and units, which have other rows between them.
void take_trace_names(const Reading& reading, std::size_t first, Dialect& dialect) {
  for (std::size_t i = 0; i < first; ++i) {
    const Line& line = reading.lines[i];
    if (line.fields.size() != reading.fields) continue;
    if (line.fields.front() == "TraceName") {
      dialect.names = line.fields;
      dialect.names.front().clear();
      dialect.header_line = line.number;
    } else if (line.fields.front() == "VUnit") {
      dialect.units = line.fields;
      dialect.units.front().clear();
    }
  }
}

/// A name that is a number would be taken for the number of a column.
void name_channels(std::vector<std::string>& names) {
  for (std::string& name : names) {
    if (!name.empty() && name.find_first_not_of("0123456789") == std::string::npos) name.insert(0, "channel ");
  }
}

/// eha-record(5): no guess is made, so that its rows are judged and not searched for.
std::optional<Dialect> record_format(const std::vector<std::string>& lines, const Options& options) {
  if (options.delimiter.value_or(',') != ',' || options.decimal.value_or('.') != '.') return std::nullopt;
  const auto first = std::find_if_not(lines.begin(), lines.end(), is_comment);
  if (first == lines.end()) return std::nullopt;
  CsvFields splitter(',');
  if (!splitter.split(*first) || splitter.size() == 0 || splitter[0] != "time_s") return std::nullopt;
  // Under a header of commas, rows may still be LibreOffice's "0,5" in quotation marks.
  const auto row = std::find_if_not(first + 1, lines.end(), is_comment);
  if (row != lines.end() && row->find("\",\"") != std::string::npos) return std::nullopt;
  Dialect dialect;
  dialect.is_record_format = true;
  for (std::size_t i = 0; i < splitter.size(); ++i) dialect.names.emplace_back(splitter[i]);
  dialect.fields = dialect.names.size();
  dialect.header_line = static_cast<std::size_t>(first - lines.begin()) + 1;
  dialect.first_data_line = dialect.header_line + 1;
  return dialect;
}

}  // namespace

bool is_comment(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t");
  if (first == std::string_view::npos) return true;
  line.remove_prefix(first);
  // A row whose first cell could not be computed.
  if (is_spreadsheet_error(line.substr(0, line.find_first_of(",;\t| \"")))) return false;
  return line[0] == '#' || line[0] == '%' || line.starts_with("//") || line.starts_with("sep=");
}

namespace {

/// What LabVIEW's header names; rows without a time begin with it.
std::optional<char> labview_separator(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    if (line.starts_with("Separator\tTab")) return '\t';
    if (line.starts_with("Separator,Comma")) return ',';
  }
  return std::nullopt;
}

}  // namespace

Dialect guess_dialect(const std::vector<std::string>& all_lines, const Options& options, const std::string& path) {
  if (auto known = record_format(all_lines, options)) return *known;
  // What LabVIEW writes above its measurement has rows of numbers, too.
  std::vector<std::string> lines = all_lines;
  const auto end_of_header = std::find_if(
      lines.rbegin(), lines.rend(), [](const std::string& line) { return line.starts_with("***End_of_Header***"); });
  std::fill(lines.begin(), end_of_header.base(), "");
  std::optional<char> told;
  if (end_of_header != lines.rend()) told = labview_separator(all_lines);
  Reading best;
  for (const char delimiter : kDelimiters) {
    if (options.delimiter.value_or(told.value_or(delimiter)) != delimiter) continue;
    for (const char decimal : kDecimals) {
      if (options.decimal.value_or(decimal) != decimal) continue;
      Reading reading = read_as(lines, delimiter, decimal);
      if (reading.score > best.score) best = std::move(reading);
    }
  }
  auto first = std::find_if(best.lines.begin(), best.lines.end(), [&](const Line& line) { return best.is_data(line); });
  if (first == best.lines.end()) {
    throw DataError(fmt::format(
        "{}: no rows of numbers found; the first line is \"{}\". Expected columns of numbers, such as time_s,voltage_V,"
        "displacement_in and below it 0,0.5,2.951",
        path, first_text(lines)));
  }
  // Names that are numbers, "x-axis,1,2", above a row of units are no row of data.
  const bool is_above_units =
      first + 1 != best.lines.end() && (first + 1)->fields.size() == best.fields && !best.is_data(*(first + 1)) &&
      std::all_of((first + 1)->fields.begin(), (first + 1)->fields.end(),
                  [](const std::string& field) { return !field.empty() && may_be_unit(field); });
  const auto later =
      is_above_units ? std::find_if(first + 1, best.lines.end(), [&](const Line& line) { return best.is_data(line); })
                     : first;
  if (later != best.lines.end()) first = later;
  // Yokogawa's rows have an empty first field, and the lines above them a word there: "BlockNumber",1,1.
  const auto bare = std::find_if(first, best.lines.end(),
                                 [&](const Line& line) { return best.is_data(line) && line.fields.front().empty(); });
  const auto begins_with_word = [&](const Line& line) {
    double ignored = 0.0;
    return !best.is_data(line) || parse_number(line.fields.front(), best.decimal, ignored) == NumberKind::none;
  };
  const auto is_bare = [&](const Line& line) { return !best.is_data(line) || line.fields.front().empty(); };
  const auto names_traces = [&](const Line& line) {
    return !line.fields.empty() && line.fields.front() == "TraceName";
  };
  const bool are_bare = bare != best.lines.end() && std::any_of(first, bare, names_traces) &&
                        std::all_of(first, bare, begins_with_word) && std::all_of(bare, best.lines.end(), is_bare);
  if (are_bare) first = bare;
  Dialect dialect;
  dialect.delimiter = best.delimiter;
  dialect.decimal = best.decimal;
  dialect.first_data_line = first->number;
  take_header(best, static_cast<std::size_t>(first - best.lines.begin()), dialect);
  if (dialect.units.empty()) {
    take_distant_header(best, static_cast<std::size_t>(first - best.lines.begin()), all_lines, dialect);
  }
  if (are_bare) take_trace_names(best, static_cast<std::size_t>(first - best.lines.begin()), dialect);
  if (is_above_units) name_channels(dialect.names);
  if (dialect.names.empty()) dialect.names = names_in_comment(lines, first->number, best);
  dialect.fields = best.fields;
  const auto ends_empty = [&](const Line& line) { return !best.is_data(line) || line.fields.back().empty(); };
  const bool named = !dialect.names.empty() && !dialect.names.back().empty();
  if (best.fields > 1 && !named && std::all_of(first, best.lines.end(), ends_empty)) --dialect.fields;
  dialect.names.resize(std::min(dialect.names.size(), dialect.fields));
  dialect.units.resize(std::min(dialect.units.size(), dialect.fields));
  dialect.has_comma_numbers =
      std::any_of(first, best.lines.end(), [](const Line& line) { return line.has_comma_number; });
  return dialect;
}

}  // namespace eha::importer
