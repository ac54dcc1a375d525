// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/own_times.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/shell_word.hpp"
#include "daemon/importer/asked_command.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/column_text.hpp"
#include "daemon/importer/time_grid.hpp"

namespace eha::importer {
namespace {

/// The commands that write input and output with the times of the coarser one; empty where the file is no text.
std::string one_grid_commands(const Table& table, const TimedColumn& input, const TimedColumn& output,
                              const std::filesystem::path& path, const Options& options) {
  const auto form = table.text_form();
  if (!form || form->delimiter == ' ') return {};
  const std::vector<Column>& columns = table.columns();
  const auto unit_s = [&](const TimedColumn& of) { return seconds_in(columns[of.time].unit).value_or(1.0); };
  const auto span_s = [&](const TimedColumn& of) {
    return (columns[of.time].sample.back() - columns[of.time].sample.front()) * unit_s(of);
  };
  const bool is_output_coarser = span_s(output) > (1.0 + kOnGrid) * span_s(input);
  const TimedColumn& coarse = is_output_coarser ? output : input;
  const TimedColumn& fine = is_output_coarser ? input : output;
  const auto time = [&](const TimedColumn& of) { return fmt::format("n(${})*{:g}", of.time + 1, unit_s(of)); };
  const auto name = [&](const TimedColumn& of, const char* role) {
    const std::string& unit = columns[of.column].unit;
    const bool is_word = std::all_of(unit.begin(), unit.end(), [](unsigned char c) { return std::isalpha(c) != 0; });
    return is_word && !unit.empty() ? fmt::format("{}_{}", role, unit) : std::string(role);
  };
  const std::string there = fmt::format("n(${})", coarse.column + 1);
  const std::string between = "y[k]+(y[k+1]-y[k])*(s-t[k])/(t[k+1]-t[k])";
  const std::string wide = path.stem().string() + "-columns.csv";
  const std::string file = shell_word(path.string());
  const std::string rows_of = fmt::format("FNR>={}&&$", form->first_data_line);
  return fmt::format(
      "`awk -F'{}' 'function n(x){{gsub(/\"/,\"\",x);{}return "
      "x+0}}NR==FNR{{if({}{}!=\"\"){{t[++m]={};y[m]=n(${})}}next}}"
      "FNR==1{{k=1;print \"time_s,{},{}\"}}{}{}!=\"\"{{s={};while(k<m-1&&t[k+1]<=s)k++;if(s>=t[1]&&s<=t[m])"
      "printf \"%.9g,%.9g,%.9g\\n\",s,{},{}}}' {} {} > {}`, then: `{}`",
      form->delimiter == '\t' ? "\\t" : std::string(1, form->delimiter),
      form->decimal == ',' ? "gsub(/,/,\".\",x);" : "", rows_of, fine.time + 1, time(fine), fine.column + 1,
      name(input, "input"), name(output, "output"), rows_of, coarse.time + 1, time(coarse),
      is_output_coarser ? between : there, is_output_coarser ? there : between, file, file, shell_word(wide),
      command_on(options, path, wide, kOfReading));
}

}  // namespace

void refuse_two_grids(const Table& table, const TimedColumn& input, const TimedColumn& output, const std::string& why,
                      const std::filesystem::path& path, const Options& options) {
  const std::vector<Column>& columns = table.columns();
  const std::string onto_one_grid = one_grid_commands(table, input, output, path, options);
  throw DataError(fmt::format(
      "{}: {} has the time {} and {} has {}, and {}; {}", path.string(), described(columns, input.column),
      described(columns, input.time), described(columns, output.column), described(columns, output.time), why,
      onto_one_grid.empty() ? "export the channels with one sample time, from one start"
                            : fmt::format("export them with one sample time, or, on straight lines between the rows of "
                                          "one at the times of the other, {}",
                                          onto_one_grid)));
}

std::string take_output_times(Rows& rows, const Table& table, const Roles& roles, const std::filesystem::path& path,
                              const Options& options) {
  const std::vector<Column>& columns = table.columns();
  const std::vector<double> own = std::move(rows.columns.back());
  rows.columns.pop_back();
  const std::vector<double>& time_s = rows.columns.front();
  if (time_s.size() < 2) return {};
  const double step_s = (time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1);
  const double unit_s = output_time_unit_s(columns, roles, path, options);
  const double later_s = own.front() * unit_s - time_s.front();
  const double digit_s = 1.01 * std::pow(10.0, -rows.time_decimals);
  const auto refuse = [&](const std::string& why) {
    refuse_two_grids(table, {*roles.time, roles.input}, {*roles.output_time, *roles.output}, why, path, options);
  };
  if (!(std::abs(later_s) < step_s))
    refuse(fmt::format("they begin {:.6g} s apart, more than a step", std::abs(later_s)));
  for (std::size_t k = 0; k < own.size(); ++k) {
    const double off_s = std::abs(own[k] * unit_s - time_s[k] - later_s);
    if (!(off_s <= std::max(kOnGrid * step_s, digit_s))) refuse(fmt::format("they part at row {}", k + 1));
  }
  if (std::abs(later_s) <= kOnGrid * step_s) return {};
  return fmt::format(
      "{} is sampled {:.3g} s {} {}, and both are read as one grid: a dead time of the model is by as much too {}",
      described(columns, *roles.output), std::abs(later_s), later_s > 0.0 ? "after" : "before",
      described(columns, roles.input), later_s > 0.0 ? "short" : "long");
}

}  // namespace eha::importer
