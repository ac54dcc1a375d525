// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/text_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/shell_word.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/importer/cell_units.hpp"
#include "daemon/importer/clock_text.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/column_text.hpp"
#include "daemon/importer/csv_fields.hpp"
#include "daemon/importer/dialect.hpp"
#include "daemon/importer/header_facts.hpp"
#include "daemon/importer/import.hpp"
#include "daemon/importer/newest_first.hpp"
#include "daemon/importer/roles.hpp"
#include "daemon/importer/split_clock.hpp"
#include "daemon/importer/text_columns.hpp"
#include "daemon/importer/text_lines.hpp"

namespace eha::importer {
namespace {

constexpr std::size_t kLinesForGuess = 2000;
constexpr std::size_t kMostColumns = 1024;
constexpr std::size_t kLinesBetweenProgress = 1U << 17U;

std::string quoted_for_message(std::string_view text) { return '"' + readable(text, kLongestShown) + '"'; }

std::string delimiter_name(char delimiter) {
  switch (delimiter) {
    case ';':
      return "semicolons";
    case '\t':
      return "tabs";
    case '|':
      return "bars";
    case ' ':
      return "blanks";
    default:
      return "commas";
  }
}

/// Decimals of the last field of the rows before.
class LastDecimals {
 public:
  void add(std::string_view field, char decimal) {
    decimals_[count_ % decimals_.size()] = decimals_of(field, decimal);
    ++count_;
  }

  /// Whether a field has fewer of them than each of those rows.
  [[nodiscard]] bool is_broken_off(std::string_view field, char decimal) const {
    if (count_ < decimals_.size()) return false;
    return decimals_of(field, decimal) < *std::min_element(decimals_.begin(), decimals_.end());
  }

 private:
  static std::size_t decimals_of(std::string_view field, char decimal) {
    const std::size_t sign = field.find(decimal);
    return sign == std::string_view::npos ? 0 : field.size() - sign - 1;
  }

  std::array<std::size_t, 30> decimals_{};
  std::size_t count_ = 0;
};

class TextTable final : public Table {
 public:
  TextTable(const std::filesystem::path& path, const Options& options, os::FileDescriptor text, const std::string& kind)
      : path_(path), options_(options), lines_(path, std::move(text)) {
    if (!kind.empty()) guesses_.push_back(kind);
    can_be_cut_ = kind.empty() && lines_.size() > 0 && lines_.encoding() != "UTF-16";
    std::vector<std::string> first = lines_.first_lines(kLinesForGuess);
    refuse_unreadable(first);
    cell_units_ = cell_units_of(first);
    if (!cell_units_.empty())
      std::transform(first.begin(), first.end(), first.begin(),
                     [&](const std::string& line) { return cell_units_.without(line); });
    dialect_ = guess_dialect(first, options, path.string());
    LabviewBlocks blocks;
    for (std::size_t k = dialect_.first_data_line; dialect_.is_of_labview && k < first.size(); ++k) {
      if (blocks.is_header(first[k])) first[k].clear();
    }
    has_blocks_ = blocks.count() > 0;
    evidence_ = SignEvidence(dialect_.delimiter);
    if (dialect_.fields > kMostColumns) {
      throw DataError(fmt::format("{}:{}: more than {} columns", path.string(), dialect_.header_line, kMostColumns));
    }
    const auto is_said = [](const std::string& line) { return line.starts_with(kClosedLoopComment); };
    says_closed_loop_ =
        dialect_.is_record_format &&
        std::any_of(first.begin(), first.begin() + static_cast<std::ptrdiff_t>(dialect_.header_line), is_said);
    if (!dialect_.is_record_format) {
      refuse_long_log(dialect_, path, options);
      told_period_s_ = period_above_rows(first, dialect_);
    }
    columns_ = named_columns(dialect_, lines_, path);
    take_cell_units();
    sample(first);
    refuse_time_stamps();
    newest_first_ = is_newest_first(columns_, first, dialect_);
    for (Column& column : columns_) {
      if (newest_first_) turn_round(column.sample, column.is_clock && !column.is_number);
    }
    if (!dialect_.is_record_format) note_guesses();
    if (newest_first_) guesses_.emplace_back("the newest row first, turned round");
  }

  [[nodiscard]] const std::vector<Column>& columns() const override { return columns_; }
  [[nodiscard]] const std::vector<std::string>& guesses() const override { return guesses_; }
  [[nodiscard]] bool is_record_format() const override { return dialect_.is_record_format; }

  [[nodiscard]] bool says_closed_loop() const override { return says_closed_loop_; }

  [[nodiscard]] std::optional<double> told_period_s() const override { return told_period_s_; }

  /// LabVIEW says the step of its channels above the rows, and may leave out the times.
  [[nodiscard]] std::optional<StatedPeriod> stated_period() const override {
    if (!dialect_.is_of_labview || !told_period_s_) return std::nullopt;
    return StatedPeriod{*told_period_s_, "Delta_X"};
  }

  [[nodiscard]] std::string place() const override {
    return dialect_.header_line > 0 ? fmt::format("{}:{}", path_.string(), dialect_.header_line) : path_.string();
  }

  [[nodiscard]] std::optional<RowPeriod> period_of_rows(std::size_t column) override {
    constexpr double kDay_s = 86400.0;
    CsvFields fields(dialect_.delimiter);
    std::vector<std::pair<double, double>> times;  // with the last digit
    ClockReader reader;
    const bool are_minutes = !columns_[column].is_clock && is_clock_of_minutes(columns_[column].sampled_text);
    LabviewBlocks blocks;
    while (const auto line = next_line()) {
      if (lines_.line() < dialect_.first_data_line || is_between_rows(*line, blocks)) continue;
      if (!fields.split(*line) || fields.size() <= column) continue;
      const std::string_view field = cell(fields, column);
      double days = 0.0;
      if (columns_[column].is_clock) {
        if (const auto time_s = reader.seconds(field)) times.emplace_back(*time_s, clock_quantum_s(field));
      } else if (are_minutes) {
        if (const auto time_s = reader.seconds(with_seconds(field))) times.emplace_back(*time_s, 60.0);
      } else if (parse_number(field, dialect_.signs, days) == NumberKind::finite) {
        // A date in double precision is known to a few microseconds, however many digits are written.
        constexpr double kFinest_s = 1e-5;
        const double digit_s = kDay_s * std::pow(10.0, -precision_of(field, dialect_.signs.decimal).decimals);
        times.emplace_back(kDay_s * days, std::max(digit_s, kFinest_s));
      }
    }
    if (newest_first_) std::reverse(times.begin(), times.end());
    RowClock clock;
    for (const auto& [time_s, digit_s] : times) clock.add(time_s, digit_s);
    return clock.period();
  }

  [[nodiscard]] std::optional<TextForm> text_form() const override {
    if (!can_be_cut_) return std::nullopt;
    return TextForm{dialect_.delimiter, dialect_.signs.decimal, dialect_.first_data_line};
  }

  [[nodiscard]] Rows read(const Selection& selection, const Progress& progress) override {
    if (!newest_first_) return read_downwards(selection, progress);
    // Times count from the oldest row, which is known at the end only.
    Selection all = selection;
    all.from = -std::numeric_limits<double>::infinity();
    all.to = std::numeric_limits<double>::infinity();
    Rows rows = read_downwards(all, progress);
    rows.has_lines = false;
    rows.line_marks.clear();
    for (std::size_t i = 0; i < rows.columns.size(); ++i) {
      const Column& column = columns_[selection.columns[i]];
      turn_round(rows.columns[i], column.is_clock && !column.is_number);
    }
    std::size_t kept = 0;
    for (std::size_t row = 0; row < rows.count(); ++row) {
      const double at = selection.has_time ? rows.columns.front()[row] : static_cast<double>(row);
      if (at < selection.from || at > selection.to) continue;
      for (auto& column : rows.columns) column[kept] = column[row];
      ++kept;
    }
    for (auto& column : rows.columns) column.resize(kept);
    return rows;
  }

 private:
  [[nodiscard]] Rows read_downwards(const Selection& selection, const Progress& progress) {
    CsvFields fields(dialect_.delimiter);
    Rows rows;
    rows.has_lines = true;
    rows.header_line = std::max<std::size_t>(dialect_.header_line, 1);
    rows.columns.resize(selection.columns.size());
    std::size_t read = 0;
    std::vector<double> values(selection.columns.size());
    double last_at = 0.0;
    constexpr double kInside = 1e-9;  // twice what a selection adds, so that its limit itself is inside
    const double last_wanted =
        std::isfinite(selection.to) ? selection.to - kInside * std::max(1.0, std::abs(selection.to)) : selection.to;
    LabviewBlocks blocks;
    LastDecimals decimals;
    while (const auto line = next_line()) {
      if (lines_.line() < dialect_.first_data_line || is_between_rows(*line, blocks)) continue;
      if (selection.keep_missing && is_spreadsheet_error(*line)) {
        // The whole row is one error.
        std::fill(values.begin(), values.end(), std::numeric_limits<double>::quiet_NaN());
        mark_line(rows);
        for (std::size_t i = 0; i < values.size(); ++i) rows.columns[i].push_back(values[i]);
        ++read;
        continue;
      }
      // What follows the last row wanted need not be a row.
      if (rows.count() > 0 && last_at >= last_wanted && !is_row(*line, fields, selection)) break;
      try {
        split(*line, fields);
        const std::string_view last = fields[dialect_.fields - 1];
        if (lines_.is_unfinished() && decimals.is_broken_off(last, dialect_.signs.decimal)) {
          rows.remarks.push_back(fmt::format(
              "{}:{}: the file ends within the number {}, without a line end and with fewer decimals than the rows "
              "before: the row is left out; copy the file again if more rows are missing",
              path_.string(), lines_.line(), quoted_for_message(last)));
          break;
        }
        decimals.add(last, dialect_.signs.decimal);
        if (!selection.has_time && is_word(fields[lead_])) refuse_number(lead_, fields[lead_], NumberKind::none, "");
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = number(fields, selection, i, rows);
      } catch (const DataError& error) {
        throw DataError(error.what() + parts_beside(std::string(*line), fields, selection, rows, last_at));
      }
      if (selection.has_time) values[0] = in_seconds(values[0], selection.time_unit_s);
      const double at = selection.has_time ? values[0] : static_cast<double>(read);
      ++read;
      if (read % kLinesBetweenProgress == 0 && progress) {
        progress(lines_.share(), fmt::format("{}: {} rows", path_.filename().string(), read));
      }
      if (at > selection.to) break;
      last_at = at;
      if (at < selection.from) continue;
      if (rows.count() == 0) reserve(rows, selection);
      if (rows.count() == kMostRows) {
        lines_.fail(fmt::format("more than {} rows; read a part of them: `{}`", kMostRows,
                                command_with(options_, path_, fmt::format("--to {:.9g}", at))));
      }
      mark_line(rows);
      for (std::size_t i = 0; i < values.size(); ++i) rows.columns[i].push_back(values[i]);
    }
    require_signs();
    if (std::abs(selection.time_unit_s - 1.0) > 0.0) {
      rows.time_decimals -= static_cast<int>(std::floor(std::log10(selection.time_unit_s)));
    }
    return rows;
  }

  [[nodiscard]] std::optional<std::string_view> next_line() {
    const auto line = lines_.next();
    if (!line || cell_units_.empty()) return line;
    plain_ = cell_units_.without(*line);
    return plain_;
  }

  void take_cell_units() {
    if (cell_units_.units.size() != columns_.size()) return;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const std::string unit = unit_of(cell_units_.units[i]);
      if (columns_[i].unit.empty()) columns_[i].unit = unit;
      if (!unit.empty() && columns_[i].unit != unit) columns_[i].other_unit = unit;
    }
  }

  /// Whether a line is none of the table: a comment, or of the header of a block of LabVIEW's.
  [[nodiscard]] bool is_between_rows(std::string_view line, LabviewBlocks& blocks) const {
    return (dialect_.is_of_labview && blocks.is_header(line)) || is_comment(line);
  }

  void refuse_unreadable(const std::vector<std::string>& first) {
    if (first.empty()) {
      // A first line that is too long, or the end of the file.
      if (!lines_.next()) {
        throw DataError(fmt::format("{}: the file is empty; expected a header of columns such as {}", path_.string(),
                                    "time_s,voltage_V,displacement_in"));
      }
      lines_.fail("this is no CSV text");
    }
    // next() would find the same faults, but only after a guess from them.
    for (std::size_t i = 0; i < first.size(); ++i) {
      if (first[i].find('\0') == std::string::npos) continue;
      throw DataError(fmt::format("{}:{}: a NUL byte: this is a binary file, not CSV text", path_.string(), i + 1));
    }
    for (std::size_t i = 0; i < first.size(); ++i) {
      if (first[i].find('\r') == std::string::npos) continue;
      while (lines_.line() <= i) static_cast<void>(lines_.next());
    }
    if (std::all_of(first.begin(), first.end(), is_comment)) {
      throw DataError(fmt::format("{}: only comments, no header row; expected a header of columns such as {}",
                                  path_.string(), "time_s,voltage_V,displacement_in"));
    }
  }

  void sample(const std::vector<std::string>& first) {
    sample_columns(columns_, first, dialect_, lines_);
    join_split_clock(first);
    const auto leads = [](const Column& column) { return column.is_number || column.is_clock; };
    lead_ = static_cast<std::size_t>(std::find_if(columns_.begin(), columns_.end(), leads) - columns_.begin());
    if (lead_ == columns_.size()) lead_ = 0;
  }

  /// A field, or that of a clock with the milliseconds behind its comma.
  [[nodiscard]] std::string_view cell(const CsvFields& fields, std::size_t column) const {
    if (column != split_clock_ || column + 1 >= fields.size()) return fields[column];
    joined_ = std::string(fields[column]) + "," + std::string(fields[column + 1]);
    return joined_;
  }

  void join_split_clock(const std::vector<std::string>& first) {
    std::vector<double> sample = sample_of_split_clock(first, dialect_, columns_, kSampledRows);
    if (sample.empty()) return;
    split_clock_ = 0;
    columns_[0].sample = std::move(sample);
    columns_[0].label = std::exchange(columns_[1].label, "");
    columns_[0].name = std::exchange(columns_[1].name, "");
    columns_[1].is_number = false;
    columns_[1].sampled_text = "milliseconds";
  }

  /// The monitor of a serial port writes "14:03:07.300 -> 0.01" where the device sends "0.01".
  void refuse_time_stamps() const {
    constexpr std::string_view kArrow = " -> ";
    for (const Column& column : columns_) {
      const std::size_t arrow = column.sampled_text.find(kArrow);
      if (arrow == std::string::npos || !clock_seconds(column.sampled_text.substr(0, arrow))) continue;
      const std::string columns = path_.stem().string() + "-columns" + path_.extension().string();
      throw DataError(fmt::format(
          "{}: \"{}\" is a time and a value in one column; `sed 's/ -> /{}/' {} > {}` parts them, then: "
          "`{}`",
          path_.string(), readable(column.sampled_text, kLongestShown),
          dialect_.delimiter == '\t' ? "\\t" : std::string(1, dialect_.delimiter), shell_word(path_.string()),
          shell_word(columns), command_on(options_, path_, columns, kOfColumns)));
    }
  }

  void note_guesses() {
    // Of a workbook the text is no file of the user's.
    if (guesses_.empty()) guesses_.push_back(delimiter_name(dialect_.delimiter));
    if (dialect_.has_comma_numbers) guesses_.emplace_back("decimal comma");
    if (dialect_.has_thousands && dialect_.are_signs_known) {
      guesses_.push_back(fmt::format("{}s between thousands", sign_name(dialect_.signs.thousands)));
    }
    if (!lines_.encoding().empty()) guesses_.push_back(lines_.encoding());
    if (dialect_.skipped_lines > 0) {
      guesses_.push_back(
          fmt::format("{} line{} of text skipped", dialect_.skipped_lines, dialect_.skipped_lines == 1 ? "" : "s"));
    }
    if (!dialect_.holds_facts.empty()) {
      guesses_.emplace_back("facts beside the rows");
    } else if (!dialect_.units.empty()) {
      guesses_.emplace_back("a row of units");
    }
    if (!cell_units_.empty()) guesses_.emplace_back("units in the cells");
    if (has_blocks_) guesses_.emplace_back("blocks with a header each, read as one");
    if (dialect_.names.empty()) guesses_.emplace_back("no header");
  }

  void split(std::string_view line, CsvFields& fields) {
    if (!fields.split(line)) lines_.fail(fmt::format("a quotation mark out of place in {}", quoted_for_message(line)));
    const bool ends_empty = fields.size() == dialect_.fields + 1 && fields[dialect_.fields].empty();
    if (fields.size() == dialect_.fields || ends_empty) return;
    const std::string as = dialect_.is_record_format || dialect_.header_line > 0
                               ? "as in the header"
                               : fmt::format("as in line {}", dialect_.first_data_line);
    const char* mend = fields.size() == 1 && is_spreadsheet_error(fields[0])
                           ? "with --resample such a row counts as not measured and is filled"
                       : fields.size() == 1 ? "the line has another separator, or is no row: correct or remove it"
                                            : "correct or remove the line";
    lines_.fail(fmt::format("expected {} columns {}, got {}; {}", dialect_.fields, as, fields.size(), mend));
  }

  /// Whether a field begins with a letter and is no missing value.
  [[nodiscard]] bool is_word(std::string_view field) const {
    if (field.empty()) return false;
    const auto first = static_cast<unsigned char>(field[0]);
    double ignored = 0.0;
    return (std::isalpha(first) != 0 || first >= 0x80) &&
           parse_number(field, dialect_.signs, ignored) == NumberKind::none;
  }

  /// Whether a line has the columns of a row, and numbers or missing values in those selected.
  [[nodiscard]] bool is_row(std::string_view line, CsvFields& fields, const Selection& selection) const {
    if (!fields.split(line) || fields.size() < dialect_.fields || fields.size() > dialect_.fields + 1) return false;
    return !is_word(fields[lead_]) &&
           std::all_of(selection.columns.begin(), selection.columns.end(), [&](std::size_t column) {
             if (columns_[column].is_clock) return clock_seconds(cell(fields, column)).has_value();
             double ignored = 0.0;
             const NumberKind kind = parse_number(fields[column], dialect_.signs, ignored);
             return kind == NumberKind::finite || kind == NumberKind::missing;
           });
  }

  /// The command on the rows behind a line: they may be without the names, and without a clock begin at 0.
  [[nodiscard]] std::string command_of_rest(const std::string& rest, const Selection& selection) const {
    std::string numbers;
    const auto number = [&](const char* option, const std::optional<std::string>& given, std::size_t at) {
      if (given && at < selection.columns.size()) {
        numbers += fmt::format("{}{} {}", numbers.empty() ? "" : " ", option, selection.columns[at] + 1);
      }
    };
    const std::size_t first = selection.has_time ? 1 : 0;
    if (selection.has_time) number("--time", options_.time, 0);
    number("--input", options_.input, first);
    number("--output", options_.output, first + 1);
    static const std::vector<std::string> kOfRows{"--from", "--to"};
    return command_on(options_, path_, rest, selection.has_time ? std::vector<std::string>() : kOfRows, numbers);
  }

  /// Commands for the rows before and behind a line of words, such as a second header or "Minimum". None for a row with
  /// a fault in it.
  [[nodiscard]] std::string parts_beside(const std::string& line, CsvFields& fields, const Selection& selection,
                                         const Rows& rows, double last_at) {
    if (!fields.split(line) || fields.size() == 0 || rows.count() < 2) return {};
    const bool is_other = fields.size() != dialect_.fields && fields.size() != dialect_.fields + 1;
    if (!is_word(fields[is_other ? 0 : lead_])) return {};
    const double unit_s = selection.has_time ? 1.0 : options_.period_s.value_or(1.0);
    std::string text = fmt::format("; the rows before it: `{}`",
                                   command_with(options_, path_, fmt::format("--to {:.12g}", last_at * unit_s)));
    const std::size_t at = lines_.line();
    if (!can_be_cut_) return text;
    std::size_t count = 0;
    while (const auto next = next_line()) {
      if (is_comment(*next) || !is_row(*next, fields, selection)) continue;
      double value = 0.0;
      const std::size_t lead = selection.columns.front();
      const bool is_timed =
          columns_[lead].is_clock || parse_number(fields[lead], dialect_.signs, value) == NumberKind::finite;
      if (is_timed) ++count;
    }
    if (count < 2) return text;
    const std::string rest = path_.stem().string() + "-rest" + path_.extension().string();
    return text + fmt::format("; the {} rows behind it: `tail -n +{} {} > {}`, then `{}`", count, at,
                              shell_word(path_.string()), shell_word(rest), command_of_rest(rest, selection));
  }

  double number(const CsvFields& fields, const Selection& selection, std::size_t i, Rows& rows) {
    const std::size_t column = selection.columns[i];
    const std::string_view field = cell(fields, column);
    if (columns_[column].is_clock && !columns_[column].is_number) {
      if (const auto time_s = clock_.seconds(field)) {
        rows.time_decimals = clock_.decimals();
        rows.time_significant = std::numeric_limits<double>::max_digits10;
        return *time_s;
      }
      if (!field.empty() || !selection.keep_missing) {
        lines_.fail(fmt::format("{}: expected a time as in the rows before, got {}", described(columns_, column),
                                quoted_for_message(field)));
      }
    }
    double value = 0.0;
    const NumberKind kind = parse_number(field, dialect_.signs, value);
    if (kind == NumberKind::finite) {
      if (!dialect_.are_signs_known) evidence_.add(column, field);
      if (i == 0) {
        const Precision precision = precision_of(field, dialect_.signs.decimal);
        rows.time_decimals = std::max(rows.time_decimals, precision.decimals);
        rows.time_significant = std::max(rows.time_significant, precision.significant);
      }
      return value;
    }
    if (kind == NumberKind::missing && (selection.keep_missing || i >= selection.may_lack_from)) return value;
    refuse_number(column, field, kind, selection.mend_missing);
  }

  /// Refuses rows whose numbers may be read in two ways, or were not read as a later one proves.
  void require_signs() const {
    if (dialect_.are_signs_known) return;
    const std::string place = path_.string();
    if (const auto proved = evidence_.proved(); proved && proved->decimal != dialect_.signs.decimal) {
      throw DataError(fmt::format("{}: {} in one column: the {} separates thousands: `{}`", place,
                                  evidence_.proof_by_whole_numbers(), sign_name(proved->thousands),
                                  command_with(options_, path_, signs_option(*proved))));
    }
    const auto ambiguous = evidence_.ambiguous();
    if (!ambiguous) return;
    std::string without = ambiguous->number;
    std::erase(without, ambiguous->sign);
    std::string decimal = ambiguous->number;
    std::replace(decimal.begin(), decimal.end(), ',', '.');
    const char* name = sign_name(ambiguous->sign);
    throw DataError(fmt::format(
        "{}: {}: is {} {} or {}? Its {} may separate thousands or be the decimal sign, and no number says which. For "
        "{}: `{}`; for {}: `{}`",
        place, described(columns_, ambiguous->column), quoted_for_message(ambiguous->number), without, decimal, name,
        without, command_with(options_, path_, fmt::format("--thousands {}", name)), decimal,
        command_with(options_, path_, fmt::format("--decimal {}", name))));
  }

  static const char* sign_name(char sign) { return sign == ',' ? "comma" : sign == '.' ? "point" : "apostrophe"; }

  /// The option that makes the reader take these signs.
  static std::string signs_option(NumberSigns signs) {
    return signs.thousands == '\0' ? fmt::format("--decimal {}", sign_name(signs.decimal))
                                   : fmt::format("--thousands {}", sign_name(signs.thousands));
  }

  [[noreturn]] void refuse_number(std::size_t column, std::string_view field, NumberKind kind,
                                  const std::string& mend) const {
    const std::string& label = columns_[column].label;
    const std::string name = label.empty() ? fmt::format("column {}", column + 1) : readable(label, kLongestShown);
    const bool is_word = !field.empty() && kind == NumberKind::missing;
    std::string what =
        fmt::format("{}: expected a {}number, got {}", name, is_word || kind == NumberKind::not_finite ? "finite " : "",
                    quoted_for_message(field));
    if (kind == NumberKind::missing && !mend.empty()) what += fmt::format("; `{}` fills missing values", mend);
    if (kind == NumberKind::none) what += signs_mend(column, field);
    lines_.fail(what);
  }

  /// The way out for a number with other signs: the option that reads it where there is one.
  [[nodiscard]] std::string signs_mend(std::size_t column, std::string_view field) const {
    // No thousands begin with 0.
    const std::string_view digits = field.substr(field.starts_with('-') || field.starts_with('+') ? 1 : 0);
    if (digits.starts_with("0.") || digits.starts_with("0,")) {
      return fmt::format("; the decimal sign of the others is a {}: correct the cell",
                         sign_name(dialect_.signs.decimal));
    }
    std::vector<NumberSigns> others;
    SignEvidence evidence = evidence_;
    evidence.add(column, field);
    const auto proved = evidence.proved();
    if (!dialect_.are_signs_known && proved) others.push_back(*proved);
    for (const char thousands : {',', '.', '\''}) others.push_back({dialect_.signs.decimal, thousands});
    for (const NumberSigns& signs : others) {
      double ignored = 0.0;
      if (signs.thousands == signs.decimal || parse_number(field, signs, ignored) != NumberKind::finite) continue;
      return fmt::format("; {}? Then: `{}`", signs.thousands == '\0' ? "another decimal sign" : "a thousands separator",
                         command_with(options_, path_, signs_option(signs)));
    }
    return has_thousands_separator(field) ? "; a thousands separator? Write the numbers without one" : "";
  }

  static double in_seconds(double time, double unit_s) {
    // Dividing keeps a printed decimal number: 1.1 ms is the double nearest to 0.0011 s.
    return unit_s < 1.0 ? time / std::round(1.0 / unit_s) : time * unit_s;
  }

  void mark_line(Rows& rows) const {
    const std::size_t row = rows.count();
    const std::size_t line = lines_.line();
    if (rows.line_marks.empty() || line - rows.line_marks.back().second != row - rows.line_marks.back().first) {
      rows.line_marks.emplace_back(row, line);
    }
  }

  /// Room for the rows that the file's size promises, so that a long column is not copied while it grows.
  void reserve(Rows& rows, const Selection& selection) const {
    const double left = std::isfinite(selection.to) ? 0.0 : 1.0 - lines_.share();
    const double read = static_cast<double>(lines_.size()) * std::max(lines_.share(), 1e-9);
    const double lines = static_cast<double>(lines_.line());
    const double expected = std::min(left * static_cast<double>(lines_.size()) / read * lines, double{kMostRows});
    if (!(expected > 0.0)) return;  // a pipe, whose length nobody knows
    // Lines get longer as the time does, so this is rather too much than too little.
    for (auto& column : rows.columns) column.reserve(static_cast<std::size_t>(expected) + 1);
  }

  std::filesystem::path path_;
  bool can_be_cut_ = false;  ///< by lines, with tail(1)
  Options options_;
  TextLines lines_;
  Dialect dialect_;
  CellUnits cell_units_;
  std::string plain_;  ///< the line just read without them
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::size_t split_clock_ = kNone;  ///< a clock whose milliseconds are the next field
  mutable std::string joined_;       ///< that clock of the row just read
  ClockReader clock_;
  SignEvidence evidence_{','};  ///< of the rows that are read, where the first lines do not tell the signs
  std::vector<Column> columns_;
  std::size_t lead_ = 0;  ///< the first column of numbers or of a clock, in which a word marks a line that is no row
  std::vector<std::string> guesses_;
  std::optional<double> told_period_s_;
  bool says_closed_loop_ = false;
  bool newest_first_ = false;
  bool has_blocks_ = false;  ///< of LabVIEW
};

}  // namespace

std::unique_ptr<Table> open_text(const std::filesystem::path& path, const Options& options, os::FileDescriptor text,
                                 const std::string& kind) {
  return std::make_unique<TextTable>(path, options, std::move(text), kind);
}

}  // namespace eha::importer
