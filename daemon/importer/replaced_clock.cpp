// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/replaced_clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "daemon/importer/column_names.hpp"
#include "daemon/importer/column_text.hpp"
#include "daemon/importer/column_values.hpp"
#include "daemon/importer/resample.hpp"

namespace eha::importer {
namespace {

constexpr double kContradicts = 0.01;  // of the period
constexpr std::ptrdiff_t kAround = 5;  // rows before and behind a gap that tell its length

bool rises(const std::vector<double>& values) {
  return values.size() > 1 &&
         std::adjacent_find(values.begin(), values.end(), [](double a, double b) { return !(b > a); }) == values.end();
}

std::vector<double> steps_of(const std::vector<double>& time_s) {
  std::vector<double> steps(time_s.size() - 1);
  for (std::size_t k = 0; k < steps.size(); ++k) steps[k] = time_s[k + 1] - time_s[k];
  return steps;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The one column that tells the time: the named one, else by its name or unit; none where it is not clear.
std::optional<std::size_t> column_of_times(const Table& table, const Roles& roles) {
  if (roles.replaced_time) return roles.replaced_time;
  const std::vector<Column>& columns = table.columns();
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Column& column = columns[i];
    if (i == roles.input || i == roles.output || !rises(column.sample)) continue;
    const bool is_number_of_row = column.unit.empty() && counts_rows(column.sample);
    const Hints hints = hints_of(column.name, column.unit);
    if (is_number_of_row || hints.is_temperature) continue;
    if (!column.is_clock && !(column.is_number && hints.time > 0)) continue;
    if (found) return std::nullopt;
    found = i;
  }
  return found;
}

/// The times of the selected rows [s]; empty where they do not tell them.
std::vector<double> times_of(std::size_t column, const Table& table, const Selection& selection, std::size_t rows,
                             const std::filesystem::path& path, const Options& options) {
  Selection times;
  times.columns = {column};
  times.has_time = true;
  try {
    times.time_unit_s = time_unit_s(table.columns()[column], path, options);
    const std::unique_ptr<Table> again = open_table(path, options);
    Rows all = again->read(times, {});
    std::vector<double>& time_s = all.columns.front();
    const auto first = static_cast<std::size_t>(std::ceil(std::max(0.0, selection.from)));
    if (time_s.size() < first + rows) return {};
    return {time_s.begin() + static_cast<std::ptrdiff_t>(first),
            time_s.begin() + static_cast<std::ptrdiff_t>(first + rows)};
  } catch (const Error&) {  // the period replaces a column that cannot be read
    return {};
  }
}

/// Whether a column without a unit of time counts in one in which it agrees with the period.
bool agrees_in_some_unit(double step, double period_s) {
  constexpr std::array kUnits_s = {1e-9, 1e-6, 1e-3, 60.0, 3600.0, 86400.0};
  return std::any_of(kUnits_s.begin(), kUnits_s.end(),
                     [&](double unit_s) { return std::abs(step * unit_s / period_s - 1.0) <= kContradicts; });
}

}  // namespace

std::vector<std::size_t> places_on_grid(const std::vector<double>& time_s) {
  constexpr double kMissing = 0.6;  // of a step, by which the clock stays ahead
  if (time_s.size() < 2 * static_cast<std::size_t>(kAround) || !rises(time_s)) return {};
  const double step_s = typical_step_s(steps_of(time_s));
  // Ahead of one place a row, which a gap raises and stamps that come early or late do not.
  std::vector<double> ahead(time_s.size());
  for (std::size_t k = 0; k < ahead.size(); ++k) {
    ahead[k] = (time_s[k] - time_s.front()) / step_s - static_cast<double>(k);
  }
  const auto median_of = [&](std::ptrdiff_t from, std::ptrdiff_t to) {
    const auto end = static_cast<std::ptrdiff_t>(ahead.size());
    return median({ahead.begin() + std::clamp<std::ptrdiff_t>(from, 0, end - 1),
                   ahead.begin() + std::clamp<std::ptrdiff_t>(to, 1, end)});
  };
  std::vector<std::size_t> places(time_s.size());
  std::size_t missing = 0;
  std::ptrdiff_t after_gap = 0;
  for (std::size_t k = 1; k < places.size(); ++k) {
    const auto row = static_cast<std::ptrdiff_t>(k);
    const double own = ahead[k] - ahead[k - 1];
    if (own > kMissing) {
      const double rise = median_of(row, row + kAround) - median_of(std::max(after_gap, row - kAround), row);
      if (rise > kMissing) {
        missing += static_cast<std::size_t>(std::max(1.0, std::round(rise)));
        after_gap = row;
      }
    }
    places[k] = k + missing;
  }
  return missing > 0 ? places : std::vector<std::size_t>();
}

ReplacedClock replaced_clock(const Table& table, const Roles& roles, const Selection& selection, std::size_t rows,
                             const std::filesystem::path& path, const Options& options) {
  ReplacedClock clock;
  const std::optional<std::size_t> column = column_of_times(table, roles);
  if (!column) return clock;
  const std::vector<double> time_s = times_of(*column, table, selection, rows, path, options);
  if (!rises(time_s)) return clock;
  const double step_s = typical_step_s(steps_of(time_s));
  const double mean_s = (time_s.back() - time_s.front()) / static_cast<double>(rows - 1);
  const double period_s = *roles.period_s;
  const auto contradicts = [&](double of_clock_s) { return std::abs(period_s / of_clock_s - 1.0) > kContradicts; };
  const Column& times = table.columns()[*column];
  const bool is_in_other_unit = !times.is_clock && times.unit.empty() && agrees_in_some_unit(step_s, period_s);
  // A gap raises the mean step, stamps that come in bursts lower the usual one.
  if (contradicts(step_s) && contradicts(mean_s) && !is_in_other_unit) {
    clock.remarks.push_back(fmt::format(
        "{}: --period takes a row every {:.6g} s, and by {} the rows are {:.6g} s apart: if the column is right, every "
        "time constant and dead time of a model is wrong by the factor {:.3g}; leave --period out then",
        path.string(), period_s, described(table.columns(), *column), step_s, period_s / step_s));
  }
  if (contradicts(step_s)) return clock;
  clock.places = places_on_grid(time_s);
  if (clock.places.empty()) return clock;
  clock.remarks.push_back(
      fmt::format("{}: by {} {} of {} rows are missing; each row is put on the grid of {:.6g} s where it belongs, and "
                  "the others are filled",
                  path.string(), described(table.columns(), *column), clock.places.back() + 1 - rows,
                  clock.places.back() + 1, period_s));
  return clock;
}

}  // namespace eha::importer
