// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/dialect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>

#include "core/error.hpp"
#include "core/text.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/csv_fields.hpp"
#include "daemon/importer/header_rows.hpp"
#include "daemon/importer/scope_facts.hpp"

namespace eha::importer {
namespace {

/// In order of preference where two explain a file equally well.
constexpr std::string_view kDelimiters = ",;\t| ";
constexpr std::string_view kDecimals = ".,";
/// The first word of the header of a block of LabVIEW's, and its last line.
constexpr std::string_view kLabviewBlock = "Channels";
constexpr std::string_view kEndOfLabviewHeader = "***End_of_Header***";

/// The other sign may separate thousands, an apostrophe too.
NumberSigns with_thousands(char decimal, std::string_view field) {
  return {decimal, field.find('\'') != std::string_view::npos ? '\'' : decimal == '.' ? ',' : '.'};
}

Line parsed(const std::string& text, std::size_t number, CsvFields& splitter, char decimal) {
  Line line;
  line.number = number;
  if (!splitter.split(text)) return line;
  std::size_t finite = 0;
  for (std::size_t i = 0; i < splitter.size(); ++i) {
    line.fields.emplace_back(splitter[i]);
    double value = 0.0;
    const NumberKind kind = parse_number(splitter[i], with_thousands(decimal, splitter[i]), value);
    if (kind == NumberKind::finite) ++finite;
    if (kind == NumberKind::finite || (kind == NumberKind::missing && !splitter[i].empty())) ++line.numbers;
    if (kind == NumberKind::finite && decimal == ',' && splitter[i].find(',') != std::string_view::npos) {
      line.has_comma_number = true;
    }
  }
  if (finite == 0) line.numbers = 0;
  return line;
}

Reading read_as(const std::vector<std::string>& texts, char delimiter, char decimal) {
  Reading reading{.delimiter = delimiter, .signs = {.decimal = decimal}, .lines = {}};
  CsvFields splitter(delimiter);
  std::map<std::size_t, double> score_of_width;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    if (is_comment(texts[i])) continue;
    Line line = parsed(texts[i], i + 1, splitter, decimal);
    if (line.numbers > 0) {
      const auto numbers = static_cast<double>(line.numbers);
      const std::size_t empty_ends =
          line.fields.size() < 3 ? 0 : (line.fields.front().empty() ? 1U : 0U) + (line.fields.back().empty() ? 1U : 0U);
      const auto width = static_cast<double>(line.fields.size() - empty_ends);
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

/// Whether a text begins as a page of the web does.
bool is_web_page(std::string_view first) {
  constexpr std::size_t kLongestBegin = 14;
  std::string begin(first.substr(0, kLongestBegin));
  std::transform(begin.begin(), begin.end(), begin.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return begin.starts_with("<html") || begin.starts_with("<!doctype html");
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

/// Takes Yokogawa's rows of names and units, which have other rows between them.
void take_trace_names(const Reading& reading, std::size_t first, Header& header) {
  for (std::size_t i = 0; i < first; ++i) {
    const Line& line = reading.lines[i];
    // The rows may end with a delimiter that the lines above lack.
    if (line.fields.size() != reading.fields && line.fields.size() + 1 != reading.fields) continue;
    if (line.fields.front() == "TraceName") {
      header.names = line.fields;
      header.names.front().clear();
      header.line = line.number;
    } else if (line.fields.front() == "VUnit") {
      header.units = line.fields;
      header.units.front().clear();
    }
  }
}

/// The line whose every other field is the word, as TwinCAT's Scope View writes "Name", "u", "Name", "x"; null: none.
const Line* line_of_pairs(const Reading& reading, std::size_t first, std::string_view word) {
  const auto end = reading.lines.begin() + static_cast<std::ptrdiff_t>(first);
  const auto found = std::find_if(reading.lines.begin(), end, [&](const Line& line) {
    if (line.fields.size() < 4 || line.fields.size() < reading.fields) return false;
    for (std::size_t i = 0; i + 1 < reading.fields; i += 2) {
      if (line.fields[i] != word) return false;
    }
    return true;
  });
  return found == end ? nullptr : &*found;
}

/// Whether a clock rises by what its SampleTime row says, or there is none: else it may number the rows.
bool is_in_ms(const Reading& reading, std::size_t first) {
  constexpr double kSame = 1e-3;
  const Line* stated = line_of_pairs(reading, first, "SampleTime[ms]");
  const auto number = [&](const std::string& field) {
    double value = 0.0;
    return parse_number(field, reading.signs, value) == NumberKind::finite ? value : 0.0;
  };
  if (stated == nullptr || first + 1 >= reading.lines.size()) return true;
  const double step_ms = number(stated->fields[1]);
  const Line& next = reading.lines[first + 1];
  return reading.is_data(next) &&
         std::abs(number(next.fields[0]) - number(reading.lines[first].fields[0]) - step_ms) <= kSame * step_ms;
}

/// Takes the names and units of pairs of a clock and a value. One clock is the time; the others have to be the same.
void take_pairs(const Reading& reading, std::size_t first, const std::string& path, Header& header) {
  const Line* names = line_of_pairs(reading, first, "Name");
  if (names == nullptr) return;
  const Line* units = line_of_pairs(reading, first, "Unit");
  header = {.line = names->number, .skipped_lines = static_cast<std::size_t>(names - reading.lines.data())};
  const bool has_ms = is_in_ms(reading, first);
  for (std::size_t i = 0; i + 1 < reading.fields; i += 2) {
    const std::string clock = has_ms ? "time" : "nr";
    header.names.insert(header.names.end(),
                        {i == 0 ? clock : fmt::format("{} {}", clock, i / 2 + 1), names->fields[i + 1]});
    header.units.insert(header.units.end(),
                        {i == 0 && has_ms ? "ms" : "", units == nullptr ? "" : units->fields[i + 1]});
  }
  for (std::size_t k = first; k < reading.lines.size(); ++k) {
    const Line& line = reading.lines[k];
    if (!reading.is_data(line)) continue;
    for (std::size_t i = 2; i + 1 < line.fields.size(); i += 2) {
      if (line.fields[i] == line.fields.front()) continue;
      throw DataError(fmt::format(
          "{}:{}: the time of {} is {} where that of {} is {}; export the channels with one sample time, from one "
          "start",
          path, line.number, readable(header.names[i + 1], kLongestShown), readable(line.fields[i], kLongestShown),
          readable(header.names[1], kLongestShown), readable(line.fields.front(), kLongestShown)));
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
  if (options.delimiter.value_or(',') != ',' || options.decimal.value_or('.') != '.' || options.thousands) {
    return std::nullopt;
  }
  const auto first = std::find_if_not(lines.begin(), lines.end(), is_comment);
  if (first == lines.end()) return std::nullopt;
  CsvFields splitter(',');
  if (!splitter.split(*first) || splitter.size() == 0 || splitter[0] != "time_s") return std::nullopt;
  // Under a header of commas, rows may still be LibreOffice's "0,5" in quotation marks.
  const auto row = std::find_if_not(first + 1, lines.end(), is_comment);
  if (row != lines.end() && row->find("\",\"") != std::string::npos) return std::nullopt;
  Dialect dialect;
  dialect.is_record_format = true;
  dialect.are_signs_known = true;
  for (std::size_t i = 0; i < splitter.size(); ++i) dialect.names.emplace_back(splitter[i]);
  dialect.fields = dialect.names.size();
  dialect.header_line = static_cast<std::size_t>(first - lines.begin()) + 1;
  dialect.first_data_line = dialect.header_line + 1;
  return dialect;
}

}  // namespace

bool LabviewBlocks::is_header(std::string_view line) {
  if (ended_) {
    // Below it stand the names of the columns again.
    const bool are_names = line.starts_with("X_Value");
    if (are_names || is_comment(line)) {
      ended_ = !are_names;
      return true;
    }
    ended_ = false;
  }
  if (line.starts_with(kLabviewBlock)) {
    inside_ = true;
    ++count_;
  }
  if (!inside_) return false;
  if (line.starts_with(kEndOfLabviewHeader)) {
    inside_ = false;
    ended_ = true;
  }
  return true;
}

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

/// The first line behind LabVIEW's headers: that of the file, and that of its first block of rows. 0: no such file.
std::size_t behind_labview_headers(const std::vector<std::string>& lines) {
  std::size_t behind = 0;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (lines[k].starts_with(kEndOfLabviewHeader)) behind = k + 1;
    const auto next = std::find_if_not(lines.begin() + static_cast<std::ptrdiff_t>(k) + 1, lines.end(), is_comment);
    if (behind == k + 1 && (next == lines.end() || !next->starts_with(kLabviewBlock))) break;
  }
  return behind;
}

/// The rows of a reading and what stands above them.
struct Layout {
  std::size_t first = 0;  ///< of reading.lines, the first row
  std::size_t width = 0;  ///< columns, without one that is empty in every row and has no name
  Header header;

  [[nodiscard]] bool is_named() const { return header.names.size() == width && are_names(header.names); }
};

/// Where the rows begin; none without any, or where most lines from there on are none.
std::optional<std::size_t> first_row(const Reading& reading, bool& are_traces) {
  const auto is_data = [&](const Line& line) { return reading.is_data(line); };
  const auto end = reading.lines.end();
  auto first = std::find_if(reading.lines.begin(), end, is_data);
  if (first == end || 2 * std::count_if(first, end, is_data) < end - first) return std::nullopt;
  // Names that are numbers, "x-axis,1,2", above a row of units are no row of data.
  const auto is_units = [](const std::string& field) { return !field.empty() && may_be_unit(field); };
  if (first + 1 != end && (first + 1)->fields.size() == reading.fields && !is_data(*(first + 1)) &&
      std::all_of((first + 1)->fields.begin(), (first + 1)->fields.end(), is_units)) {
    const auto later = std::find_if(first + 1, end, is_data);
    if (later != end) first = later;
  }
  // Rows of a preamble above the names, "Vertical Scale,1.0,0.5", are none either.
  const auto is_word = [&](const std::string& field) {
    double ignored = 0.0;
    return parse_number(field, reading.signs, ignored) == NumberKind::none;
  };
  const auto names =
      std::find_if_not(first, end, [&](const Line& line) { return is_data(line) && is_word(line.fields[0]); });
  if (names != first && end - names > 1 && names->fields.size() == reading.fields && !is_data(*names) &&
      are_names(names->fields) && is_data(*(names + 1)) && !is_word((names + 1)->fields[0])) {
    first = names + 1;
  }
  // Yokogawa's rows have an empty first field, and the lines above them a word there: "BlockNumber",1,1.
  const auto bare = std::find_if(first, end, [&](const Line& line) { return is_data(line) && line.fields[0].empty(); });
  const auto begins_with_word = [&](const Line& line) { return !is_data(line) || is_word(line.fields[0]); };
  const auto is_bare = [&](const Line& line) { return !is_data(line) || line.fields[0].empty(); };
  const auto names_traces = [](const Line& line) { return !line.fields.empty() && line.fields[0] == "TraceName"; };
  are_traces = bare != end && std::any_of(reading.lines.begin(), bare, names_traces) &&
               std::all_of(first, bare, begins_with_word) && std::all_of(bare, end, is_bare);
  if (are_traces) first = bare;
  return static_cast<std::size_t>(first - reading.lines.begin());
}

/// Whether a line above the rows has a word in their last field.
bool is_last_named(const Reading& reading, std::size_t first) {
  for (std::size_t i = first; i-- > 0 && reading.lines[i].fields.size() == reading.fields;) {
    if (!reading.lines[i].fields.back().empty()) return true;
  }
  return false;
}

std::optional<Layout> layout_of(const Reading& reading, const std::vector<std::string>& all_lines) {
  Layout layout;
  bool are_traces = false;
  const std::optional<std::size_t> first = first_row(reading, are_traces);
  if (!first) return std::nullopt;
  layout.first = *first;
  layout.width = reading.fields;
  const auto from = reading.lines.begin() + static_cast<std::ptrdiff_t>(*first);
  const bool end_empty = reading.fields > 1 && std::all_of(from, reading.lines.end(), [&](const Line& line) {
                           return !reading.is_data(line) || line.fields.back().empty();
                         });
  if (end_empty && !is_last_named(reading, *first)) --layout.width;
  layout.header = header_above(reading, *first, layout.width, all_lines);
  if (are_traces) take_trace_names(reading, *first, layout.header);
  return layout;
}

bool has_number_with(const Line& line, NumberSigns signs) {
  return std::any_of(line.fields.begin(), line.fields.end(), [&](const std::string& field) {
    double ignored = 0.0;
    return field.find(signs.thousands) != std::string::npos &&
           parse_number(field, signs, ignored) == NumberKind::finite;
  });
}

/// Rows such as "0,01,0,0000,0,048" below three names.
void refuse_commas_for_both(const Reading& reading, const Layout& layout, const std::string& path) {
  if (reading.delimiter != ',' || layout.is_named() || layout.first == 0) return;
  const Line& above = reading.lines[layout.first - 1];
  if (!are_names(above.fields) || 2 * above.fields.size() != reading.fields) return;
  throw DataError(
      fmt::format("{}:{}: {} names above rows of {} fields: commas stand between the columns and in the numbers, too. "
                  "Export the file "
                  "with semicolons between the columns, or with decimal points",
                  path, above.number, above.fields.size(), reading.fields));
}

/// Takes the signs that the options say or the rows prove. Of numbers that may be read in two ways the sign is decimal
/// until a later row proves something.
void set_signs(const Reading& reading, std::size_t first, const Options& options, Dialect& dialect) {
  SignEvidence evidence(reading.delimiter);
  bool has_commas = false;
  for (std::size_t k = first; k < reading.lines.size(); ++k) {
    const Line& line = reading.lines[k];
    if (!reading.is_data(line)) continue;
    for (std::size_t i = 0; i < dialect.fields; ++i) evidence.add(i, line.fields[i]);
    has_commas = has_commas || line.has_comma_number;
  }
  const std::optional<NumberSigns> proved = evidence.proved();
  const auto other = [](char sign) { return sign == ',' ? '.' : ','; };
  NumberSigns& signs = dialect.signs;
  dialect.are_signs_known = true;
  if (options.thousands && *options.thousands != '\'') {
    signs = {other(*options.thousands), *options.thousands};
  } else if (options.decimal || options.thousands) {
    signs.decimal = options.decimal.value_or(proved ? proved->decimal : signs.decimal);
    signs.thousands = options.thousands.value_or(other(signs.decimal));
  } else if (proved) {
    signs = *proved;
  } else if (const auto ambiguous = evidence.ambiguous()) {
    signs = {ambiguous->sign, other(ambiguous->sign)};
    dialect.are_signs_known = false;
  } else {
    dialect.are_signs_known = false;
  }
  dialect.has_comma_numbers = has_commas && signs.decimal == ',';
  for (std::size_t k = first; k < reading.lines.size() && signs.thousands != '\0'; ++k) {
    const Line& line = reading.lines[k];
    dialect.has_thousands = dialect.has_thousands || (reading.is_data(line) && has_number_with(line, signs));
  }
}

}  // namespace

Dialect guess_dialect(const std::vector<std::string>& all_lines, const Options& options, const std::string& path) {
  if (auto known = record_format(all_lines, options)) return *known;
  // What LabVIEW writes above its measurement has rows of numbers, too.
  std::vector<std::string> lines = all_lines;
  const std::size_t behind_headers = behind_labview_headers(lines);
  std::fill(lines.begin(), lines.begin() + static_cast<std::ptrdiff_t>(behind_headers), "");
  LabviewBlocks blocks;
  for (std::size_t k = behind_headers; behind_headers > 0 && k < lines.size(); ++k) {
    if (blocks.is_header(lines[k])) lines[k].clear();
  }
  // So does what a scope of Tektronix writes.
  const std::optional<std::size_t> scope_header = scope_header_line(all_lines);
  if (scope_header) {
    std::fill(lines.begin(), lines.begin() + static_cast<std::ptrdiff_t>(*scope_header), "");
    if (lines[*scope_header].starts_with('#')) lines[*scope_header].erase(0, 1);
  }
  std::optional<char> told;
  if (behind_headers > 0) told = labview_separator(all_lines);
  std::vector<Reading> readings;
  for (const char delimiter : kDelimiters) {
    if (options.delimiter.value_or(told.value_or(delimiter)) != delimiter) continue;
    for (const char decimal : kDecimals) {
      if (options.decimal.value_or(decimal) != decimal || options.thousands == decimal) continue;
      readings.push_back(read_as(lines, delimiter, decimal));
    }
  }
  // Blanks in a line of text above tabs make as many fields as there are columns, but name none.
  constexpr double kAboutAsGood = 0.95;
  double best_score = 0.0;
  for (const Reading& reading : readings) best_score = std::max(best_score, reading.score);
  const Reading* best = nullptr;
  std::optional<Layout> layout;
  for (const Reading& reading : readings) {
    if (!(reading.score > 0.0) || reading.score < kAboutAsGood * best_score) continue;
    std::optional<Layout> tried = layout_of(reading, all_lines);
    if (!tried) continue;
    // Of equal ones the first delimiter, and under it the better decimal sign.
    const bool is_better = !layout || (tried->is_named() && !layout->is_named()) ||
                           (tried->is_named() == layout->is_named() && reading.delimiter == best->delimiter &&
                            reading.score > best->score);
    if (!is_better) continue;
    best = &reading;
    layout = std::move(tried);
  }
  if (!layout) {
    if (is_web_page(first_text(lines))) {
      throw DataError(fmt::format(
          "{}: is a web page: what was fetched is a page about the file, or one that asks to log in; fetch the file "
          "itself",
          path));
    }
    throw DataError(fmt::format(
        "{}: no rows of numbers found; the first line is \"{}\". Expected columns of numbers, such as time_s,voltage_V,"
        "displacement_in and below it 0,0.5,2.951",
        path, first_text(lines)));
  }
  refuse_commas_for_both(*best, *layout, path);
  take_pairs(*best, layout->first, path, layout->header);
  Dialect dialect;
  dialect.is_of_labview = behind_headers > 0;
  dialect.delimiter = best->delimiter;
  dialect.signs = best->signs;
  dialect.first_data_line = best->lines[layout->first].number;
  dialect.fields = layout->width;
  dialect.header_line = layout->header.line;
  dialect.skipped_lines = layout->header.skipped_lines;
  dialect.names = std::move(layout->header.names);
  dialect.units = std::move(layout->header.units);
  name_channels(dialect.names);
  if (scope_header && *scope_header + 1 < dialect.first_data_line) {
    take_facts_above(all_lines, *scope_header, dialect);
    dialect.skipped_lines = *scope_header;
  } else if (dialect.names.empty() && !take_facts_beside(all_lines, dialect)) {
    dialect.names = names_in_comment(lines, dialect.first_data_line, *best);
  }
  dialect.names.resize(std::min(dialect.names.size(), dialect.fields));
  set_signs(*best, layout->first, options, dialect);
  return dialect;
}

}  // namespace eha::importer
