// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/import.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "core/shell_word.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/importer/clock_text.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/column_text.hpp"
#include "daemon/importer/imported_table.hpp"
#include "daemon/importer/lone_rows.hpp"
#include "daemon/importer/missing_codes.hpp"
#include "daemon/importer/output_findings.hpp"
#include "daemon/importer/own_times.hpp"
#include "daemon/importer/refusals.hpp"
#include "daemon/importer/replaced_clock.hpp"
#include "daemon/importer/resample.hpp"
#include "daemon/importer/roles.hpp"
#include "daemon/importer/slow_rows.hpp"
#include "daemon/importer/time_grid.hpp"
#include "daemon/importer/two_units.hpp"
#include "daemon/importer/written_on_change.hpp"
#include "ident/signal/measured_rows.hpp"

namespace eha::importer {
namespace {

constexpr std::size_t kMostRowsAsEven = 1'000'000;

Eigen::VectorXd as_vector(const std::vector<double>& column) {
  return Eigen::Map<const Eigen::VectorXd>(column.data(), static_cast<Eigen::Index>(column.size()));
}

/// Copies a column and frees its vector, so that a long record is not held twice.
Eigen::VectorXd taken(std::vector<double>& column) {
  Eigen::VectorXd values = as_vector(column);
  std::vector<double>().swap(column);
  return values;
}

void check(const Options& options) {
  if (options.from_s && options.to_s && !(*options.from_s < *options.to_s)) {
    throw UsageError(fmt::format("--from {:g} --to {:g}: expected the first to be below the second", *options.from_s,
                                 *options.to_s));
  }
}

Selection selection_for(const Table& table, const Roles& roles, const std::filesystem::path& path,
                        const Options& options) {
  Selection selection;
  const std::vector<Column>& columns = table.columns();
  double scale = 1.0;
  if (roles.time) {
    selection.columns.push_back(*roles.time);
    selection.has_time = true;
    selection.time_unit_s = time_unit_s(columns[*roles.time], path, options);
  } else {
    scale = 1.0 / *roles.period_s;
  }
  selection.columns.push_back(roles.input);
  if (roles.output) selection.columns.push_back(*roles.output);
  if (roles.filled) selection.columns.push_back(*roles.filled);
  if (roles.output_time) {
    selection.may_lack_from = selection.columns.size();
    selection.columns.push_back(*roles.output_time);
  }
  // Half of a billionth, so that a time that is the limit itself is inside.
  constexpr double kInside = 5e-10;
  const auto margin = [](double x) { return kInside * std::max(1.0, std::abs(x)); };
  if (options.from_s) selection.from = *options.from_s * scale - margin(*options.from_s * scale);
  if (options.to_s) selection.to = *options.to_s * scale + margin(*options.to_s * scale);
  selection.keep_missing = options.resample;
  if (roles.output) selection.mend_missing = command_with(options, path, "--resample");
  return selection;
}

/// The channel of a column, with a name that a header of a record can hold.
/// @param unit  instead of the column's, if there is one
ident::Channel channel_of(Column column, const std::optional<std::string>& unit, const char* otherwise,
                          bool is_record_format) {
  if (unit) column.unit = *unit;
  if (is_record_format) return {column.name, column.unit};
  std::string name = column.name.substr(column.name.find_last_of("./") + 1);
  // Behind an underscore would be the unit.
  for (char& c : name) {
    if (c == ',' || c == '"' || c == '\n') c = ' ';
    if (c == '_' && column.unit.empty()) c = ' ';
    if (c == ' ' && !column.unit.empty()) c = '_';
  }
  // A reader trims names.
  name.erase(0, name.find_first_not_of(' '));
  name.erase(name.find_last_not_of(' ') + 1);
  if (name.empty() || name.front() == '(') name = otherwise;
  return {name, column.unit};
}

/// Gives input and output different names, as the header of a record needs.
void tell_apart(ident::Channel& input, ident::Channel& output) {
  if (input.name != output.name || input.unit != output.unit) return;
  input.name = input.unit.empty() ? "input " + input.name : "input_" + input.name;
  output.name = output.unit.empty() ? "output " + output.name : "output_" + output.name;
}

/// For a step that no hydraulic rig is sampled with: the time has another unit, or is none. A rod, whose place is a
/// length, moves within a second.
std::string remark_on_pace(double step_s, const std::string& output_unit, const std::filesystem::path& path) {
  constexpr double kLongest_s = 1e6;
  constexpr double kLongestOfRod_s = 0.99;  // a record of 1 kHz in milliseconds
  if (step_s >= kShortestStep_s && step_s <= (is_length(output_unit) ? kLongestOfRod_s : kLongest_s)) return {};
  const std::string in_ms = step_s > 1.0 ? "" : fmt::format(", for milliseconds --period {:.6g}", 1e-3 * step_s);
  return fmt::format("{}: a row every {:.3g} s is {}: check the unit of the time; --period gives the sample period{}",
                     path.string(), step_s,
                     step_s < kShortestStep_s ? "faster than any hydraulic rig is sampled"
                     : is_length(output_unit) ? "slow for a rod, if the output is one"
                                              : "very slow",
                     step_s < kShortestStep_s ? "" : in_ms);
}

constexpr double kSameTime = 1e-5;  // of the time between rows
constexpr const char* kClosedLoop =
    "a controller probably made the input from it and the output: of a closed loop a model may be biased, most where "
    "noise and load move the output; record with the loop open, or hold the model against such a record (`eha "
    "validate`)";

/// The set point of the rod beside input and output; none without one.
std::optional<std::size_t> set_point_beside(const Table& table, const Roles& roles) {
  const std::vector<Column>& columns = table.columns();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (i == roles.input || i == roles.output || i == roles.time || !columns[i].is_number) continue;
    const Hints hints = hints_of(columns[i].name, columns[i].unit);
    const std::vector<double>& sample = columns[i].sample;
    const auto moves = [&](double x) { return std::abs(x - sample.front()) > 0.0; };
    // A reference in volts that never moves is a sensor's supply.
    if (hints.is_set_point || (hints.is_demand_as_input && std::any_of(sample.begin(), sample.end(), moves))) return i;
  }
  return std::nullopt;
}

/// Period of rows whose time stamps scatter [s].
double mean_period_s(const std::vector<double>& time_s) {
  return round_period((time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1), time_s.size());
}

/// For rows that were moved to an even grid.
std::string remark_on_moved_rows(const Resampled& even, const std::vector<double>& time_s) {
  const std::size_t rows = even.columns.front().size();
  constexpr double kWorthSaying = 0.01;  // of the rows, and of a step
  const bool is_small = static_cast<double>(even.moved_rows) < kWorthSaying * static_cast<double>(rows) ||
                        even.most_moved_s < kWorthSaying * even.step_s;
  if (is_small) return {};
  if (even.is_averaged) {
    return fmt::format(
        "{} of {} rows were up to {:.3g} s off an even step of {:.6g} s: as if their times were those of the samples, "
        "the output is interpolated, and the input the mean over each step of what was held{}",
        even.moved_rows, rows, even.most_moved_s, even.step_s,
        // Where rows are missing it would shorten the record.
        even.filled.empty() ? fmt::format("; if the rows were sampled evenly and only the clock is uneven, --period "
                                          "{:.6g} takes them so",
                                          mean_period_s(time_s))
                            : std::string());
  }
  return fmt::format(
      "{} of {} rows were moved by up to {:.3g} s to an even step of {:.6g} s: the input takes effect by as much "
      "earlier or later than a model has it, so that its figures are less exact than their intervals say; record with "
      "an even clock",
      even.moved_rows, rows, even.most_moved_s, even.step_s);
}

/// How a column of times is read: " (a clock, in seconds from its first row; 2 "t" agrees)".
std::string time_reading(const Column& time, const Roles& roles) {
  std::vector<std::string> facts;
  if (time.is_clock) facts.emplace_back("a clock, in seconds from its first row");
  if (roles.time_unit_assumed) facts.emplace_back("taken as seconds");
  if (!roles.time_note.empty()) facts.push_back(roles.time_note);
  return facts.empty() ? "" : fmt::format(" ({})", fmt::join(facts, "; "));
}

/// Whether the columns are those of a record and no others, so that none of them was chosen.
bool is_in_order_of_record(const Table& table) {
  const std::vector<Column>& columns = table.columns();
  return table.is_record_format() && table.guesses().empty() &&
         (columns.size() <= 3 || (columns.size() == 4 && columns[3].name == kFilledColumn));
}

std::string guess_text(const Table& table, const Roles& roles, const std::filesystem::path& path,
                       const ident::Record& record) {
  const std::vector<Column>& columns = table.columns();
  if (is_in_order_of_record(table)) return {};
  const auto shown = [&](std::size_t i) { return described_with_unit(columns, i); };
  std::string text = path.string() + ": ";
  if (!table.guesses().empty()) text += fmt::format("{}; ", fmt::join(table.guesses(), ", "));
  text += roles.time
              ? fmt::format("time {}{}{}", shown(*roles.time), time_reading(columns[*roles.time], roles),
                            roles.output_time ? fmt::format(", the grid of {} too", shown(*roles.output_time)) : "")
              : fmt::format("a row every {:.9g} s{}", *roles.period_s,
                            roles.period_name.empty() ? "" : fmt::format(" (the file's {})", roles.period_name));
  text += fmt::format(", input {}", shown(roles.input));
  if (roles.output) text += fmt::format(", output {}", shown(*roles.output));
  return text + fmt::format("; {} rows every {:.9g} s", record.input.size(), record.step_s);
}

/// Codes for missing values in one column: asked about, or taken as not measured.
/// @param time_of  time of a row [s]
template <typename TimeOf>
bool take_missing_codes(Rows& rows, std::size_t column, bool is_output, const TimeOf& time_of,
                        const std::filesystem::path& path, const Options& options, Imported& imported) {
  std::vector<MissingCode> codes = missing_codes(rows.columns[column]);
  // An input may well be 0.
  if (auto lost = is_output ? dropouts(rows.columns[column]) : std::nullopt) codes.push_back(std::move(*lost));
  for (const MissingCode& code : codes) {
    const std::string found = missing_code_text(code, is_output ? "the output" : "the input");
    if (options.resample) {
      imported.repairs.push_back(found + "; taken as not measured");
      for (const std::size_t row : code.rows) rows.columns[column][row] = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    const auto [first, last] = longest_part_without(code.rows, rows.count());
    std::string part;
    if (first > 0) part += fmt::format("--from {:.9g}", time_of(first));
    if (last + 1 < rows.count()) part += fmt::format("{}--to {:.9g}", part.empty() ? "" : " ", time_of(last));
    throw DataError(fmt::format(
        "{}{}: {}; to take them as not measured and fill them: `{}`; the longest part without, {:.3g} s: `{}`",
        path.string(), rows.where(code.rows.front()), found, command_with(options, path, "--resample"),
        time_of(last) - time_of(first), command_with(options, path, part)));
  }
  return !codes.empty();
}

/// The end of a refusal of a clock whose rows are not even: what they tell together.
std::string taken_as_even(const Rows& rows, const std::filesystem::path& path, const Options& options) {
  RowClock clock;
  for (const double at : rows.columns.front()) clock.add(at, std::pow(10.0, -rows.time_decimals));
  const std::optional<RowPeriod> period = clock.period();
  return period ? "; taken as even, " + period_offer(*period, path, options) : "";
}

/// Columns whose unit the file tells, and no option.
std::vector<std::size_t> told_by_file(std::vector<std::size_t> columns, const Roles& roles, const Options& options) {
  std::erase_if(columns, [&](std::size_t i) {
    return (options.input_unit && i == roles.input) || (options.output_unit && i == roles.output);
  });
  return columns;
}

/// The columns as selected: without a time, one of zeros would only cost.
Imported assembled(Rows& rows, const Table& table, const Roles& roles, const Selection& selection,
                   const std::filesystem::path& path, const Options& options) {
  Imported imported;
  const ReplacedClock clock = roles.time || !options.period_s
                                  ? ReplacedClock()
                                  : replaced_clock(table, roles, selection, rows.count(), path, options);
  imported.remarks = remarks_on_two_units(table.columns(), told_by_file(selection.columns, roles, options), path);
  imported.remarks.insert(imported.remarks.end(), rows.remarks.begin(), rows.remarks.end());
  imported.remarks.insert(imported.remarks.end(), clock.remarks.begin(), clock.remarks.end());
  const bool fills = options.resample || !clock.places.empty();
  ident::Record& record = imported.record;
  if (roles.output_time) {
    if (std::string remark = take_output_times(rows, table, roles, path, options); !remark.empty()) {
      imported.remarks.push_back(path.string() + ": " + remark);
    }
  }
  const std::string mend = command_with(options, path, "--resample");
  if (!roles.time) {
    if (rows.count() < 2) {
      throw DataError(fmt::format("{}: {} row{}; at least two are needed", path.string(), rows.count(),
                                  rows.count() == 1 ? "" : "s"));
    }
    record.step_s = *roles.period_s;
    record.start_s = std::max(0.0, std::ceil(options.from_s.value_or(0.0) / record.step_s - 1e-9)) * record.step_s;
    if (fills) {
      std::vector<double> time_s(rows.count());
      for (std::size_t k = 0; k < time_s.size(); ++k) {
        time_s[k] = record.start_s + static_cast<double>(clock.places.empty() ? k : clock.places[k]) * record.step_s;
      }
      rows.columns.insert(rows.columns.begin(), std::move(time_s));
    }
  }
  if (roles.time) refuse_time_without_unit(rows, table.columns()[*roles.time], path, options);
  const std::size_t first = roles.time || fills ? 1 : 0;
  bool is_even = !roles.time && clock.places.empty();
  if (options.resample) {
    is_even = std::all_of(rows.columns.begin(), rows.columns.end(), [](const auto& column) {
      return std::all_of(column.begin(), column.end(), [](double x) { return std::isfinite(x); });
    });
  }
  if (roles.time && (is_even || !options.resample)) {
    try {
      record.step_s = even_step_s(rows, path, options);
      record.start_s = rows.columns[0].front();
      is_even = !options.period_s || std::abs(*options.period_s - record.step_s) <= 1e-9 * record.step_s;
    } catch (const DataError& error) {
      const std::string what = error.what();
      const bool is_clock = table.columns()[*roles.time].is_clock;
      if (!options.resample && is_clock && what.find("--period") == std::string::npos &&
          what.find("the longest part") == std::string::npos) {
        throw DataError(what + taken_as_even(rows, path, options));
      }
      if (!options.resample || rows.count() < 2) throw;
      is_even = false;
    }
  }
  const auto time_of = [&](std::size_t row) {
    return first == 1 ? rows.columns[0][row] : record.start_s + static_cast<double>(row) * record.step_s;
  };
  if (options.resample && roles.output) {
    if (const auto held = hold_written_on_change(rows.columns[first])) imported.repairs.push_back(*held);
  }
  for (const std::size_t at : {first, first + 1}) {
    if (at > first && !roles.output) continue;
    if (take_missing_codes(rows, at, at > first, time_of, path, options, imported)) is_even = false;
  }
  for (const std::size_t at : {first, first + 1}) {
    if (!roles.output || options.keep_lone_rows) break;
    const bool is_input = at == first;
    const std::vector<std::size_t> lone =
        is_input ? lone_inputs(rows.columns[first]) : lone_rows(rows.columns[first], rows.columns[at]);
    if (!lone.empty()) {
      const std::string found =
          lone_rows_text(lone, rows.columns[at], time_of(lone.front()), is_input ? "input" : "output");
      if (!options.resample) {
        throw DataError(
            fmt::format("{}{}: {}; {}, and a single such row spoils a model; to take them as not measured and fill "
                        "them: `{}`; if they "
                        "were measured so, to take them as they are: `{}`",
                        path.string(), rows.where(lone.front()), found,
                        is_input ? "a lost decimal point or a disturbed wire does that"
                                 : "a loose contact or a disturbed sensor does that, no motion",
                        mend, command_with(options, path, "--keep-lone-rows")));
      }
      imported.repairs.push_back(found + "; taken as not measured");
      for (const std::size_t row : lone) rows.columns[at][row] = std::numeric_limits<double>::quiet_NaN();
      is_even = false;
    }
  }
  if (!is_even && fills) {
    Resampled even = resample(rows, 1, options.period_s, path);
    record.step_s = even.step_s;
    record.start_s = even.start_s;
    record.unmeasured = std::move(even.filled);
    imported.held = std::move(even.held);
    if (std::string remark = remark_on_moved_rows(even, rows.columns[0]); !remark.empty()) {
      imported.remarks.push_back(path.string() + ": " + remark);
      if (even.is_averaged && even.filled.empty() && roles.output && rows.count() <= kMostRowsAsEven) {
        imported.as_even = ident::Record{};
        imported.as_even->step_s = mean_period_s(rows.columns[0]);
        imported.as_even->input = as_vector(rows.columns[first]);
        imported.as_even->output = as_vector(rows.columns[first + 1]);
      }
    }
    std::move(even.repairs.begin(), even.repairs.end(), std::back_inserter(imported.repairs));
    for (std::size_t i = 0; i < even.columns.size(); ++i) rows.columns[first + i] = std::move(even.columns[i]);
  }
  if (first == 1) std::vector<double>().swap(rows.columns[0]);
  record.input = taken(rows.columns[first]);
  if (roles.output) record.output = taken(rows.columns[first + 1]);
  if (roles.filled) {
    const std::vector<double>& marks = rows.columns[first + (roles.output ? 2 : 1)];
    std::vector<std::size_t> marked;
    for (std::size_t k = 0; k < marks.size(); ++k) {
      if (marks[k] > 0.5) marked.push_back(k);
    }
    for (std::vector<std::size_t>* rows_of : {&record.unmeasured, &imported.held}) {
      std::vector<std::size_t> all;
      std::set_union(marked.begin(), marked.end(), rows_of->begin(), rows_of->end(), std::back_inserter(all));
      *rows_of = std::move(all);
    }
  }
  return imported;
}

/// Gives each row the input of so many rows later; the last rows, whose input is not known, are left out.
void shift_input_back(std::size_t rows, const std::filesystem::path& path, Imported& imported) {
  ident::Record& record = imported.record;
  const auto by = static_cast<Eigen::Index>(rows);
  const Eigen::Index count = record.input.size() - by;
  if (rows == 0) return;
  if (count < 2) {
    throw DataError(fmt::format("{}: --input-late {} leaves {} of {} rows; at least two are needed", path.string(),
                                rows, std::max<Eigen::Index>(0, count), record.input.size()));
  }
  const auto behind = static_cast<std::size_t>(count);
  record.input = record.input.tail(count).eval();
  if (record.output.size() > 0) record.output = record.output.head(count).eval();
  // A row lacks what its output or the input that it gets lacks.
  std::vector<std::size_t> held = ident::rows_within(imported.held, rows, behind);
  std::vector<std::size_t> own;
  std::set_difference(record.unmeasured.begin(), record.unmeasured.end(), imported.held.begin(), imported.held.end(),
                      std::back_inserter(own));
  own = ident::rows_within(own, 0, behind);
  record.unmeasured.clear();
  std::set_union(own.begin(), own.end(), held.begin(), held.end(), std::back_inserter(record.unmeasured));
  imported.held = std::move(held);
}

/// The same question with all that its command needs: rows that only --resample reads are named at once.
std::string asked_at_once(const ColumnsAsked& asked, const std::filesystem::path& path, const Progress& progress) {
  const auto refusal = [&](const Options& options) -> std::optional<std::string> {
    try {
      static_cast<void>(import_record(path, options, progress));
      return std::nullopt;
    } catch (const Error& error) {
      return error.what();
    }
  };
  Options answer = asked.answer();
  const std::optional<std::string> why = answer.resample ? std::nullopt : refusal(answer);
  answer.resample = true;
  if (!why || refusal(answer)) return asked.what();
  return fmt::format("{} Its rows need --resample: {}. For example: `{} --resample`", asked.question(),
                     why->substr(0, why->find(';')), asked.command());
}

/// The roles of a record's columns, or one refusal with all that is needed.
Roles roles_of(Table& table, const std::filesystem::path& path, const Options& options, const Progress& progress) {
  try {
    return find_record(table, path, options);
  } catch (const ColumnsAsked& asked) {
    throw DataError(asked_at_once(asked, path, progress));
  }
}

}  // namespace

Imported import_record(const std::filesystem::path& path, const Options& options, const Progress& progress) {
  check(options);
  const std::unique_ptr<Table> table = open_table(path, options);
  const Roles roles = roles_of(*table, path, options, progress);
  refuse_slower_output(*table, roles, path, options);
  const Selection selection = selection_for(*table, roles, path, options);
  Rows rows = table->read(selection, progress);
  Imported imported = assembled(rows, *table, roles, selection, path, options);
  const bool own = table->is_record_format();
  shift_input_back(options.input_late, path, imported);
  imported.record.input_channel = channel_of(table->columns()[roles.input], options.input_unit, "input", own);
  imported.record.output_channel = channel_of(table->columns()[*roles.output], options.output_unit, "output", own);
  if (!own) tell_apart(imported.record.input_channel, imported.record.output_channel);
  if (own) refuse_exchanged(imported.record, roles, path, options);
  const ident::Record& record = imported.record;
  imported.guess = guess_text(*table, roles, path, record);
  if (std::string remark = remark_on_pace(record.step_s, options.period_s ? "" : record.output_channel.unit, path);
      !remark.empty())
    imported.remarks.push_back(remark);
  const std::optional<std::size_t> set_point =
      is_in_order_of_record(*table) ? std::nullopt : set_point_beside(*table, roles);
  imported.is_closed_loop = set_point || table->says_closed_loop();
  if (imported.is_closed_loop) {
    imported.remarks.push_back(
        fmt::format("{}: {}, so that {}", path.string(),
                    set_point ? fmt::format("column {} is a set point", described(table->columns(), *set_point))
                              : std::string("the file that it was imported from had a set point"),
                    kClosedLoop));
  }
  // A plain record without units has nothing but the order of its columns either.
  const bool is_without_units = record.input_channel.unit.empty() && record.output_channel.unit.empty();
  const std::string why =
      why_exchanged({record.input.begin(), record.input.end()}, {record.output.begin(), record.output.end()});
  imported.exchange = fmt::format("--input {} --output {}", *roles.output + 1, roles.input + 1);
  if (!why.empty() && (roles.by_order || (own && is_without_units))) {
    imported.remarks.push_back(fmt::format("{}: input and output {}may be exchanged: {}; the other way round: `{}`",
                                           path.string(),
                                           options.input || options.output ? "" : "are taken by their order, and ", why,
                                           command_with(options, path, imported.exchange)));
  }
  OutputFindings findings =
      findings_on_output({record.input.begin(), record.input.end()}, {record.output.begin(), record.output.end()},
                         imported.held, record.start_s, record.step_s, !why.empty());
  for (const std::string& remark : findings.remarks) imported.remarks.push_back(path.string() + ": " + remark);
  // Rows whose output is interpolated answer as late as the interpolation makes them.
  constexpr double kMostInterpolated = 0.1;
  const bool is_measured =
      static_cast<double>(record.unmeasured.size()) <= kMostInterpolated * static_cast<double>(record.output.size());
  if (is_measured) imported.slow_rows = remark_on_slow_rows(record.input, record.output, record.step_s);
  if (!imported.slow_rows.empty()) {
    imported.remarks.push_back(path.string() + ": " + imported.slow_rows);
  } else if (is_measured && !imported.is_closed_loop) {
    imported.slow_rows = motion_within_rows(record.input, record.output, record.step_s);
  }
  imported.cut = findings.cut;
  imported.frozen = std::move(findings.frozen);
  imported.without_gaps =
      part_without_gaps(imported.held, static_cast<std::size_t>(record.output.size()), record.start_s, record.step_s);
  imported.gaps = gaps_text(imported.held, record.start_s, record.step_s);
  return imported;
}

ImportedInput import_input(const std::filesystem::path& path, const Options& options, const std::string& unit,
                           const Progress& progress) {
  check(options);
  const std::unique_ptr<Table> table = open_table(path, options);
  const Roles roles = find_input(*table, path, options, unit);
  const Selection selection = selection_for(*table, roles, path, options);
  Rows rows = table->read(selection, progress);
  ImportedInput input;
  std::vector<double> time_s = roles.time ? rows.columns[0] : std::vector<double>();
  const Imported imported = assembled(rows, *table, roles, selection, path, options);
  const ident::Record& record = imported.record;
  const auto even = [&](std::size_t k) {
    constexpr double kPerSecond = 1e9;  // keeps 0.07 from 0.07000000000000001
    return std::round((record.start_s + static_cast<double>(k) * record.step_s) * kPerSecond) / kPerSecond;
  };
  // Times in minutes are rounded to 0.0833: the rows are simulated at even times.
  bool is_as_read = time_s.size() == static_cast<std::size_t>(record.input.size()) && imported.repairs.empty();
  for (std::size_t k = 0; is_as_read && k < time_s.size(); ++k) {
    is_as_read = std::abs(time_s[k] - even(k)) <= kSameTime * record.step_s;
  }
  if (!is_as_read) {
    time_s.resize(static_cast<std::size_t>(record.input.size()));
    for (std::size_t k = 0; k < time_s.size(); ++k) time_s[k] = even(k);
  }
  input.series.time_s = std::move(time_s);
  input.series.values = record.input;
  input.series.step_s = record.step_s;
  input.series.channel =
      channel_of(table->columns()[roles.input], options.input_unit, "input", table->is_record_format());
  if (!unit.empty() && !input.series.channel.unit.empty()) {
    input.series.values *= unit_factor(input.series.channel.unit, unit).value_or(1.0);
    input.series.channel.unit = unit;
  }
  input.guess = guess_text(*table, roles, path, record);
  input.remarks = remarks_on_two_units(table->columns(), told_by_file(selection.columns, roles, options), path);
  if (std::string remark = remark_on_pace(record.step_s, "", path); !remark.empty()) input.remarks.push_back(remark);
  return input;
}

}  // namespace eha::importer
